// Everything the author of a scene includes.
//
// Dependencies between the folders: docs/architecture.md.
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
