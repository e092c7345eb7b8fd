"""Shows that the core is one program: same vectors, every runtime, same digest; no allocation, no overflow."""
