#pragma once

#include "pipeline/smooth/smoother.h"

namespace slim {

/// Smooths a cloud batch by batch onto the surface fitted anew to it (run_smooth says what).
/// Returns its keys.
nlohmann::json smooth_cloud(const Smoother& smoother);

}  // namespace slim
