"""One brushless joint in integers: field-oriented current control, cascade, sensing, protection, states.

Three calls run a joint (see tick.py): ``current_step`` per current step, ``motion_tick`` per
millisecond, ``slow_tick`` ten times a second. Blocks and units are in layout.py, docs/joint.md.
"""
