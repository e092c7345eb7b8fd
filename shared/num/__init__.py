"""Numbers: fixed point, tables, filters, PID."""
