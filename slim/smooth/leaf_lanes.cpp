#include "slim/smooth/leaf_lanes.h"

#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

using V = stdx::native_simd<double>;

bool is_plain(const Surfel& s) { return !s.sharp && s.degree <= 2; }

Vec3<V> in_lanes(const Vec3d& v) { return {V(v.x), V(v.y), V(v.z)}; }

/// A number that is no root.
const V kNone = std::numeric_limits<double>::infinity();

/// Of two roots the one nearer to the guess, the first if they are equally near.
[[gnu::always_inline]] inline V nearer(const V& a, const V& b, const V& guess) {
    return select<V>(stdx::abs(b - guess) < stdx::abs(a - guess), b, a);
}

/// The root of k0 + k1 t + k2 t^2 in [-half, half] that is nearest the guess, or kNone. As
/// quadratic_roots(), but for the discriminant, which is rounded as it comes: where it is near zero
/// the line touches the surface, and its gate leaves the root out.
[[gnu::always_inline]] inline V nearest_root(const V& k0, const V& k1, const V& k2, const V& half,
                                             const V& guess) {
    constexpr double kTangent = 4 * std::numeric_limits<double>::epsilon();
    const V discriminant = k1 * k1 - 4 * k2 * k0;
    const auto curved = k2 != 0;
    const auto tangent = curved && stdx::abs(discriminant) < kTangent * k1 * k1;
    const V root = stdx::sqrt(stdx::max(discriminant, V(0)));
    const V q = -0.5 * (k1 + select<V>(k1 < 0, -root, root));
    const V one = select<V>(q != 0, k0 / q, select<V>(curved, V(0), kNone));
    const V other = select<V>(curved, q / k2, kNone);
    V low = stdx::min(one, other), high = stdx::max(one, other);
    const V touch = -k1 / (2 * k2);
    low = select<V>(tangent, touch, low), high = select<V>(tangent, touch, high);
    const auto is_root = [&](const V& t) {
        return (tangent || discriminant >= 0) && t >= -half && t <= half;
    };
    return nearer(select<V>(is_root(low), low, kNone), select<V>(is_root(high), high, kNone),
                  guess);
}

}  // namespace

/// What rims leave of the weights at local (u, v).
[[gnu::always_inline]] inline V LeafLanes::rim_share(const Group& s, const V& u, const V& v) {
    const auto of = [&](const auto& rim) {
        return stdx::clamp((rim.reach - (rim.u * u + rim.v * v)) / kRimRamp, V(0), V(1));
    };
    return stdx::min(of(s.rims[0]), of(s.rims[1]));
}

/// Sums of eqs (6) and (7) by lanes.
struct LeafLanes::Sums {
    V weight = 0, t = 0;
    Vec3<V> gradient{V(0), V(0), V(0)};

    void add(const Group& s, const V& g, const V& along, const V& d_u, const V& d_v) {
        weight += g, t += g * along;
        gradient += s.frame.world_from_local({-d_u * g, -d_v * g, g});
    }
    Vec3d direction() const {
        return {stdx::reduce(gradient.x), stdx::reduce(gradient.y), stdx::reduce(gradient.z)};
    }
};

void LeafLanes::gather(const BallIndex& index, const Bbox& box) {
    index.near(box, numbers_);
    plain_ = std::all_of(numbers_.begin(), numbers_.end(),
                         [&](std::uint32_t i) { return is_plain(index.leaf(i)); });
    groups_.clear();
    if (!plain_) return;
    for (std::size_t first = 0; first < numbers_.size(); first += kGroup)
        groups_.push_back(group_of(index, first));
    holds_.assign(groups_.size(), 0);
    weight_.resize(groups_.size() * kGroup);
}

LeafLanes::Group LeafLanes::group_of(const BallIndex& index, std::size_t first) const {
    const auto lanes = [&](auto&& value, double without) {
        return V([&](auto lane) {
            const std::size_t k = first + lane;
            return k < numbers_.size() ? value(index.leaf(numbers_[k])) : without;
        });
    };
    const auto vector = [&](auto&& value) {
        return Vec3<V>{lanes([&](const Surfel& s) { return value(s).x; }, 0),
                       lanes([&](const Surfel& s) { return value(s).y; }, 0),
                       lanes([&](const Surfel& s) { return value(s).z; }, 0)};
    };
    Group out;
    out.center = vector([](const Surfel& s) { return s.center; });
    out.frame = {vector([](const Surfel& s) { return s.frame.u_axis; }),
                 vector([](const Surfel& s) { return s.frame.v_axis; }),
                 vector([](const Surfel& s) { return s.frame.normal; })};
    out.radius = lanes([](const Surfel& s) { return s.support_radius; }, 0);
    out.inverse_radius = 1.0 / out.radius;
    for (std::size_t i = 0; i < out.a.size(); ++i)
        out.a[i] = lanes([i](const Surfel& s) { return s.polynomial.a[i]; }, 0);
    out.any_rims = false;
    for (std::size_t k = first; k < std::min(first + kGroup, numbers_.size()); ++k)
        out.any_rims |= index.leaf(numbers_[k]).rims.any();
    if (!out.any_rims) return out;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto rim = [i](const Surfel& s) {
            return unpack_rim(i == 0 ? s.rims.first : s.rims.second);
        };
        out.rims[i] = {lanes([&](const Surfel& s) { return rim(s).u; }, 1),
                       lanes([&](const Surfel& s) { return rim(s).v; }, 0),
                       lanes([&](const Surfel& s) { return rim(s).reach; }, 0)};
    }
    return out;
}

[[gnu::flatten]] std::optional<LanePut> LeafLanes::project_along(const Vec3d& p, const Vec3d& n) {
    const Vec3<V> at = in_lanes(p), along = in_lanes(n);
    Sums sums;
    for (std::size_t k = 0; k < groups_.size(); ++k) {
        const Group& s = groups_[k];
        const Vec3<V> to_center = s.center - at;
        const V sq_center = sq_length(to_center);
        const auto holds = sq_center < s.radius * s.radius;
        holds_[k] = lane_bits(holds);
        if (holds_[k] == 0) continue;
        const V from_center = sq_center * s.inverse_radius * s.inverse_radius;
        weight_kernel(from_center).copy_to(&weight_[k * kGroup], stdx::element_aligned);
        // As local_ray() and ray_polynomial().
        const V t_base = dot(to_center, along);
        const Vec3<V> b = s.frame.local_from_world((along * t_base - to_center) * s.inverse_radius);
        const Vec3<V> d = s.frame.local_from_world(along);
        const auto d_u = [&](const V& u, const V& v) {
            return s.a[1] + 2 * s.a[3] * u + s.a[4] * v;
        };
        const auto d_v = [&](const V& u, const V& v) {
            return s.a[2] + 2 * s.a[5] * v + s.a[4] * u;
        };
        const V k0 = b.z - (s.a[0] + b.x * (s.a[1] + b.x * s.a[3]) +
                            b.y * (s.a[2] + b.y * s.a[5] + b.x * s.a[4]));
        const V k1 = d.z - (d_u(b.x, b.y) * d.x + d_v(b.x, b.y) * d.y);
        const V k2 = -(d.x * d.x * s.a[3] + d.x * d.y * s.a[4] + d.y * d.y * s.a[5]);
        const V half = stdx::sqrt(stdx::max(1.0 - sq_length(b), V(0)));
        const V guess = -t_base * s.inverse_radius;
        const V t = nearest_root(k0, k1, k2, half, guess);
        const Vec3<V> root = b + d * t;
        const V u_slope = d_u(root.x, root.y), v_slope = d_v(root.x, root.y);
        const V share = s.any_rims ? rim_share(s, root.x, root.y) : V(1);
        const auto counts = holds && stdx::abs(t - guess) <= kBelongs &&
                            d.z - u_slope * d.x - v_slope * d.y > 0 && share > 0;
        if (lane_bits(counts) == 0) continue;
        // A surfel that does not count may have no numbers.
        const auto counted = [&](const V& v) { return select<V>(counts, v, V(0)); };
        sums.add(s, counted(share * weight_kernel(sq_length(root))), counted(t_base + s.radius * t),
                 counted(u_slope), counted(v_slope));
    }
    const double weight = stdx::reduce(sums.weight);
    if (!(weight > 0)) return std::nullopt;
    return LanePut{p + n * (stdx::reduce(sums.t) / weight), normalized(sums.direction())};
}

[[gnu::flatten]] std::optional<Vec3d> LeafLanes::normal_at(const Vec3d& p) {
    const Vec3<V> at = in_lanes(p);
    Sums sums;
    gradients_.clear();
    for (const Group& s : groups_) {
        const Vec3<V> x = (at - s.center) * s.inverse_radius;
        const V sq = sq_length(x);
        const auto holds = sq < 1.0;
        if (lane_bits(holds) == 0) continue;
        const V u = dot(s.frame.u_axis, x), v = dot(s.frame.v_axis, x);
        const auto held = [&](const V& value) { return select<V>(holds, value, V(0)); };
        const Vec3<V> before = sums.gradient;
        sums.add(s, held(weight_kernel(sq)), V(0), held(s.a[1] + 2 * s.a[3] * u + s.a[4] * v),
                 held(s.a[2] + 2 * s.a[5] * v + s.a[4] * u));
        gradients_.push_back(sums.gradient - before);
    }
    const Vec3d sum = sums.direction();
    if (!(sq_length(sum) > 0)) return std::nullopt;
    const Vec3<V> mean = in_lanes(sum);
    for (const Vec3<V>& g : gradients_)
        if (lane_bits(dot(g, mean) < 0) != 0) return std::nullopt;
    return normalized(sum);
}

}  // namespace slim
