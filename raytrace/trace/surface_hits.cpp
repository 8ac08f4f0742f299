#include "raytrace/trace/surface_hits.h"

#include <bit>

namespace slim {

TraceCounts& TraceCounts::operator+=(const TraceCounts& b) {
    rays += b.rays, nodes_visited += b.nodes_visited;
    root_tests += b.root_tests, distance_tests += b.distance_tests;
    return *this;
}

void SurfaceHits::take(const FloatV::mask_type& lanes, const SurfaceHits& from,
                       Derivatives wanted) {
    const auto take = [&](FloatV& to, const FloatV& x) { to = select<FloatV>(lanes, x, to); };
    const auto take_vec = [&](LanesOfVec& to, const LanesOfVec& x) {
        to = select_vec(lanes, x, to);
    };
    take(t, from.t), take(first_t, from.first_t), take(first_t_low, from.first_t_low);
    take_vec(point, from.point), take_vec(point_low, from.point_low);
    take_vec(normal, from.normal), take(clearance, from.clearance);
    take(sums.weight, from.sums.weight), take(sums.passing, from.sums.passing);
    take(sums.offset, from.sums.offset), take(sums.count, from.sums.count);
    take(sums.spread, from.sums.spread), take_vec(sums.gradient, from.sums.gradient);
    // Without a hit these were not set.
    const auto hits = lanes && from.hit();
    if (wanted >= Derivatives::second)
        for (std::size_t n = 0; stdx::any_of(hits) && n < 6; ++n)
            take(sums.hessian[n], from.sums.hessian[n]);
    if (wanted >= Derivatives::third)
        for (std::size_t n = 0; stdx::any_of(hits) && n < 10; ++n)
            take(sums.third[n], from.sums.third[n]);
    for (std::uint64_t bits = lane_bits(hits); bits != 0; bits &= bits - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(bits));
        model[k] = from.model[k], record[k] = from.record[k];
    }
}

}  // namespace slim
