#pragma once

#include "pipeline/smooth/smoother.h"

namespace slim {

/// Smooths a mesh's vertices by the planes of its faces (run_smooth says what). Returns its keys.
nlohmann::json smooth_faces(const Smoother& smoother);

}  // namespace slim
