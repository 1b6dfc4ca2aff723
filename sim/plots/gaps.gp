# For scripts that plot a trace over time: shades rows without a valid sample of the device or with the run on
# hold. 32: bit `held` of column limited.
gap(dummy) = (int(column("limited")) & 32) ? 1 : NaN
set y2range [0:1]
