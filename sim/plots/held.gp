# For scripts that plot one body: selects that body, or for a device that grips bodies the gripped one of each
# row (none while it holds none). Needs body, or bodies: all names in the order of the scene file.
holds = exists("bodies")
nothing(dummy) = holds ? column("held") < 0 : 0
name_now(dummy) = holds ? word(bodies, int(column("held")) + 1) : body
of_tool(name) = nothing(0) ? NaN : column(name_now(0).".".name)
of_target(name) = nothing(0) ? NaN : column(name_now(0).".target.".name)
shown(name) = column(holds ? "hand.".name : body.".feedback.".name)
what = holds ? "the held body" : body
