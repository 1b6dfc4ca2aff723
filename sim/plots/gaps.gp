# For the scripts that plot a trace over time: rows in which the device had no valid sample, or the run was on hold, are
# shaded. 32: the bit `held` of the column limited.
gap(dummy) = (int(column("limited")) & 32) ? 1 : NaN
set y2range [0:1]
