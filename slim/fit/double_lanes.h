#pragma once

#include "slim/base/simd.h"

#include <cstddef>
#include <vector>

namespace slim {

using DoubleLanes = stdx::native_simd<double>;

/// The numbers from a[i] on as doubles.
template <class T>
DoubleLanes double_lanes_at(const std::vector<T>& a, std::size_t i) {
    return stdx::static_simd_cast<DoubleLanes>(LanesOfDouble<T>(&a[i], stdx::element_aligned));
}

}  // namespace slim
