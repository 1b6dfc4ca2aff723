// Public header of the core: includes all that the author of a scene needs.
//
// Dependencies between the folders: docs/architecture.md.
#pragma once

#include "core/compiled_step.h"
#include "core/device/cues.h"
#include "core/device/holding.h"
#include "core/energy.h"
#include "core/energy_balance.h"
#include "core/hash.h"
#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "core/joint/tree.h"
#include "core/setup.h"
#include "core/step.h"
#include "core/term/constant_force.h"
#include "core/term/coordinate_spring.h"
#include "core/term/damped_spring.h"
#include "core/term/loop_joint.h"
