//! A distributed ray tracer whose lens tilts, swings and shifts.
