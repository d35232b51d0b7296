"""Newton steps on active sets, alone and by turns with sweeps."""
