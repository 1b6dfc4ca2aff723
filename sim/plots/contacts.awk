# Extracts from a trace: t, penetration, number of contacts, largest |contact force| on a body, residual.
NR == 1 {
  for (i = 1; i <= NF; i++) {
    at[$i] = i
    if ($i ~ /\.contact\.fx$/) fx[++n] = i
  }
  next
}
{
  largest_sq = 0
  for (k = 1; k <= n; k++) {
    f_sq = $fx[k] ^ 2 + $(fx[k] + 1) ^ 2 + $(fx[k] + 2) ^ 2
    if (f_sq > largest_sq) largest_sq = f_sq
  }
  print $at["t"], $at["penetration"], $at["contacts"], sqrt(largest_sq), $at["contact_residual"]
}
