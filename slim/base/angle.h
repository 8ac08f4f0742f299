#pragma once

#include <numbers>

namespace slim {

inline constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace slim
