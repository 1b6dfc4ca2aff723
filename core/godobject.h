// Everything the author of a scene includes.
//
// The room: scene.h says what a scene is a type of and what it has to store; step.h is the time step, stage.h and
// solve_stage.h one stage of an integrator, node_stage.h that of particles; integrator_*.h are the two schemes; setup.h
// checks before the first step; energy.h, energy_balance.h and gain_watch.h watch over it, hash.h and fault.h say what came
// out; tuning.h has every number that physics does not give. Folders below it depend on each other as
// docs/architecture.md draws them.
#pragma once

#include "core/device/holding.h"
#include "core/energy.h"
#include "core/energy_balance.h"
#include "core/hash.h"
#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "core/joint/tree.h"
#include "core/setup.h"
#include "core/step.h"
#include "core/term/damped_spring.h"
