"""One brushless joint in integers: field-oriented current control, cascade, sensing, protection, states.

Three calls run a joint: ``current_step`` per current step (current.py), ``motion_tick`` per millisecond (tick.py),
``slow_tick`` ten times a second (thermal.py). Blocks and units are in layout.py, docs/joint.md.
"""
