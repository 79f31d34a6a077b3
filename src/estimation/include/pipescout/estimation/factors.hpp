// SPDX-License-Identifier: Apache-2.0
#pragma once

/// All measurements and factors of this library: a header and a source each.
#include "pipescout/estimation/body_velocity_factor.hpp"
#include "pipescout/estimation/centre_line_factor.hpp"
#include "pipescout/estimation/gps_factor.hpp"
#include "pipescout/estimation/heading_factor.hpp"
#include "pipescout/estimation/height_factor.hpp"
#include "pipescout/estimation/magnetic_field_factor.hpp"
#include "pipescout/estimation/non_holonomic_factor.hpp"
#include "pipescout/estimation/odometer_factor.hpp"
#include "pipescout/estimation/position_factor.hpp"
#include "pipescout/estimation/prior_factor.hpp"
#include "pipescout/estimation/range_factor.hpp"
#include "pipescout/estimation/relative_pose_factor.hpp"
#include "pipescout/estimation/velocity_factor.hpp"
#include "pipescout/estimation/visual_pose_factor.hpp"
#include "pipescout/estimation/weld_factor.hpp"
#include "pipescout/estimation/zero_angular_rate_factor.hpp"
#include "pipescout/estimation/zero_velocity_factor.hpp"
