# For the scripts that plot one body: that body, or where the device takes hold of bodies the one that it holds in each
# row and nothing while it holds none. Needs body, or bodies: all names in the order of the scene file.
holds = exists("bodies")
nothing(dummy) = holds ? column("held") < 0 : 0
name_now(dummy) = holds ? word(bodies, int(column("held")) + 1) : body
of_tool(name) = nothing(0) ? NaN : column(name_now(0).".".name)
of_target(name) = nothing(0) ? NaN : column(name_now(0).".target.".name)
shown(name) = column(holds ? "hand.".name : body.".feedback.".name)
what = holds ? "the held body" : body
