#include "slim/cover/surfel_points.h"

#include "slim/base/simd.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

namespace slim {
namespace {

constexpr float kAtCenter = 0.9999999f;
constexpr double kExplained = 4;  // residuals up to this many eps belong to the surfel
constexpr double kBeside = 9;     // up to this many sqrt(lambda): beside it; rims scatter so far
constexpr double kEdgeSlope = 0.5;   // sine of the angle between the normals at an edge, 30 degrees
constexpr double kAcuteSlope = 0.17;  // the same of normals that face away: an edge of 10 degrees
constexpr double kNotBeside = 0.35;  // of rho: no farther, or what the surfel is blended from ends

/// Whether a point's normal faces the other way than the sheet that it lies nearest to.
bool faces_away(const Surfel& s, const Vec3d& x, const Vec3d& normal) {
    const Vec3d g = s.sheet_gradient(s.active_sheet(x), x);
    return dot(g, normal) < static_cast<double>(kOtherSideCos) * length(g);
}

using Lanes = stdx::native_simd<double>;

Lanes lanes_at(const std::vector<double>& a, std::size_t i) {
    return {&a[i], stdx::element_aligned};
}

/// f at the ball's points, a group at a time, and who is near enough to be looked at.
/// Other sheets' points and padding have sq = 2 and are passed over.
class Residuals {
public:
    Residuals(const Surfel& surfel, const BallPoints<double>& ball) : surfel_(surfel), ball_(ball) {
        const auto spread = [](const Vec3d& v) {
            return Vec3<Lanes>{Lanes(v.x), Lanes(v.y), Lanes(v.z)};
        };
        frame_ = {spread(surfel.frame.u_axis), spread(surfel.frame.v_axis),
                  spread(surfel.frame.normal)};
        for (std::size_t k = 0; k < polynomial_.a.size(); ++k)
            polynomial_.a[k] = surfel.polynomial.a[k];
    }
    /// Bits of the points of group `first` that lie no farther than `most`; their f is in off(),
    /// their place in the tangent plane in u(), v().
    std::uint64_t within(double most, std::size_t first) {
        const Lanes sq = lanes_at(ball_.sq, first);
        const Vec3<Lanes> local = frame_.local_from_world(
            {lanes_at(ball_.x, first), lanes_at(ball_.y, first), lanes_at(ball_.z, first)});
        u_ = local.x, v_ = local.y;
        off_ = local.z - polynomial_.value(local.x, local.y);
        if (surfel_.sharp) off_ = Lanes([&](auto lane) { return joined_at(first + lane); });
        return lane_bits(sq < 1.0 && stdx::abs(off_) <= most);
    }
    /// Bits of those of the group that lie no farther than that, whoever they are.
    std::uint64_t no_farther_than(double most) const { return lane_bits(stdx::abs(off_) <= most); }
    const Lanes& off() const { return off_; }
    const Lanes& u() const { return u_; }
    const Lanes& v() const { return v_; }

private:
    double joined_at(std::size_t i) const {
        return surfel_.value({ball_.x[i], ball_.y[i], ball_.z[i]});
    }
    const Surfel& surfel_;
    const BallPoints<double>& ball_;
    Frame<Lanes> frame_;
    Polynomial<Lanes> polynomial_;
    Lanes off_ = 0, u_ = 0, v_ = 0;
};

/// What is told of a group's covered points, in memory.
struct CoveredLanes {
    alignas(64) float weight[Lanes::size()], u[Lanes::size()], v[Lanes::size()], off[Lanes::size()];

    CoveredLanes(const Residuals& residuals, const Lanes& weights) {
        const auto store = [](const Lanes& from, float* to) {
            stdx::static_simd_cast<LanesOfDouble<float>>(from).copy_to(to, stdx::element_aligned);
        };
        store(weights, weight), store(residuals.u(), u), store(residuals.v(), v),
            store(residuals.off(), off);
    }
};

/// How a normal at a point leans over a smooth surfel, in its tangent plane.
struct Lean {
    double u, v, along;  ///< its parts along the plane, and along the frame's normal
    double slope;        ///< of (u, v): the sine of the angle, where the surfel is level
};

Lean lean_of(const Surfel& s, const Vec3d& local, const Vec3d& normal) {
    const Vec3d n = s.frame.local_from_world(normal);
    const double u = n.x + n.z * s.polynomial.d_u(local.x, local.y);
    const double v = n.y + n.z * s.polynomial.d_v(local.x, local.y);
    return {u, v, n.z, std::sqrt(u * u + v * v)};
}

/// The sign of an edge that a point of the ball is to a smooth surfel; nothing if its normal is too
/// much alike. n . (x - p) = 0 for x on the surfel, which is taken as its tangent plane over the
/// point.
std::optional<EdgeSign> edge_sign(const Surfel& s, const Vec3d& p, const Vec3d& normal,
                                  double least_slope = kEdgeSlope) {
    const Vec3d x = s.frame.local_from_world(p);
    const Lean lean = lean_of(s, x, normal);
    if (!(lean.slope > least_slope)) return {};
    const double above = s.polynomial.value(x.x, x.y) - x.z;
    const double reach = (lean.u * x.x + lean.v * x.y - lean.along * above) / lean.slope;
    return EdgeSign{static_cast<float>(lean.u / lean.slope),
                    static_cast<float>(lean.v / lean.slope), static_cast<float>(reach)};
}

/// The covered points that are an edge's own. The surfel's normal at its centre stands for those
/// all over it, so that few are looked at closely.
class EdgePoints {
public:
    EdgePoints(const Surfel& surfel, const BallPoints<double>& ball)
        : surfel_(surfel), ball_(ball), normal_(normalized(surfel.sheet_gradient(0, {}))) {}
    /// Adds point i of the ball if it is one.
    void add(std::size_t i, std::vector<EdgePoint>& out) const {
        const Vec3d normal{ball_.nx[i], ball_.ny[i], ball_.nz[i]};
        if (!(dot(normal, normal_) < kEdgeCos) || !(sq_length(normal) > 0)) return;
        const Vec3d x = surfel_.frame.local_from_world({ball_.x[i], ball_.y[i], ball_.z[i]});
        const Lean lean = lean_of(surfel_, x, normal);
        if (lean.slope > kEdgeSlope)
            out.push_back({static_cast<float>(lean.u / lean.slope),
                           static_cast<float>(lean.v / lean.slope), static_cast<float>(x.x),
                           static_cast<float>(x.y)});
    }

private:
    const Surfel& surfel_;
    const BallPoints<double>& ball_;
    Vec3d normal_;
};

/// How far from a surfel, over rho, a point may lie that it covers.
double tolerance_of(const FittedSurfel& f, double noise) {
    return std::min(kExplained * std::max(f.fit_error, noise) / f.surfel.support_radius, kBelongs);
}

}  // namespace

[[gnu::flatten]] Footprint footprint_of(const BallPoints<double>& ball,
                                        const Frame<double>& frame) {
    Lanes weight = 0, gu = 0, gv = 0;                         // under G
    Lanes n_middle = 0;
    // plain: under G a few points are a line by chance
    Lanes n = 0, u1 = 0, v1 = 0, uu = 0, uv = 0, vv = 0;
    for (std::size_t first = 0; first < ball.n; first += Lanes::size()) {
        const Lanes x = lanes_at(ball.x, first), y = lanes_at(ball.y, first),
                    z = lanes_at(ball.z, first);
        const Lanes sq = lanes_at(ball.sq, first);
        const Lanes u = x * frame.u_axis.x + y * frame.u_axis.y + z * frame.u_axis.z;
        const Lanes v = x * frame.v_axis.x + y * frame.v_axis.y + z * frame.v_axis.z;
        const Lanes g = weight_kernel(sq), one = select(sq < 1.0, Lanes(1), Lanes(0));
        weight += g, gu += g * u, gv += g * v;
        n_middle += select(sq < 0.25, Lanes(1), Lanes(0));
        n += one, u1 += one * u, v1 += one * v;
        uu += one * u * u, uv += one * u * v, vv += one * v * v;
    }
    const auto sum = [](const Lanes& lanes) { return stdx::reduce(lanes); };
    Footprint out;
    if (sum(weight) > 0) out.lean = (frame.u_axis * sum(gu) + frame.v_axis * sum(gv)) / sum(weight);
    if (!(sum(n) > 0)) return out;
    out.middle = sum(n_middle) / sum(n);
    const double u = sum(u1) / sum(n), v = sum(v1) / sum(n);
    const double a = sum(uu) / sum(n) - u * u, b = sum(uv) / sum(n) - u * v,
                 c = sum(vv) / sum(n) - v * v;
    out.breadth = std::sqrt(std::max(0.0, (a + c) / 2 - std::hypot((a - c) / 2, b)));
    return out;
}

bool misses_center(const FittedSurfel& f, double noise_variance, double clearly) {
    return std::abs(f.surfel.polynomial.a[0]) >
           tolerance_of(f, std::sqrt(noise_variance)) + clearly;
}

void list_acute_edges(const BallPoints<double>& ball, std::span<const SetAside<double>> aside,
                      CoveringSurfel& out) {
    const Surfel& s = out.fitted.surfel;
    for (const SetAside<double>& a : aside) {
        const std::size_t i = a.index;
        const Vec3d normal{ball.nx[i], ball.ny[i], ball.nz[i]};
        if (dot(normal, s.frame.normal) >= static_cast<double>(kOtherSideCos)) continue;
        const auto sign = edge_sign(s, {ball.x[i], ball.y[i], ball.z[i]}, normal, kAcuteSlope);
        if (sign) out.edges.push_back(*sign);
    }
}

[[gnu::flatten]] void list_points(const PointTree& tree, const BallPoints<double>& ball,
                                  double noise_variance, CoveringSurfel& out) {
    const Surfel& s = out.fitted.surfel;
    const double noise = std::sqrt(noise_variance);
    const double tolerance = tolerance_of(out.fitted, noise);
    const double beside = std::min(kBeside * noise / s.support_radius, kNotBeside);
    out.covered.resize(ball.n);
    std::size_t n_covered = 0;
    Residuals residuals(s, ball);
    const EdgePoints edge_points(s, ball);
    for (std::size_t first = 0; first < ball.n; first += Lanes::size()) {
        const std::uint64_t near = residuals.within(std::max(tolerance, beside), first);
        const CoveredLanes lanes(residuals, weight_kernel(lanes_at(ball.sq, first)));
        const std::uint64_t inside = s.sharp ? 0 : lane_bits(lanes_at(ball.sq, first) < 1.0);
        for (std::uint64_t bits = inside & ~near; bits != 0; bits &= bits - 1) {
            const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(bits));
            const auto sign = edge_sign(s, {ball.x[i], ball.y[i], ball.z[i]},
                                        {ball.nx[i], ball.ny[i], ball.nz[i]});
            if (sign) out.edges.push_back(*sign);
        }
        const std::uint64_t explained = residuals.no_farther_than(tolerance);
        for (std::uint64_t bits = near; bits != 0; bits &= bits - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
            const std::size_t i = first + lane;
            if (s.sharp && faces_away(s, {ball.x[i], ball.y[i], ball.z[i]},
                                      {ball.nx[i], ball.ny[i], ball.nz[i]}))
                continue;
            const std::uint32_t point = tree.source(ball.index[i]);
            if ((explained >> lane & 1) == 0) {
                out.beside.push_back(point);
                continue;
            }
            out.covered[n_covered++] = {point,           lanes.weight[lane],
                                        lanes.u[lane],   lanes.v[lane],
                                        lanes.off[lane], ball.sq[i] < kTrim * kTrim};
            // The heaviest weight is G(0) = 1, which only points at the centre have.
            out.explains_center |= lanes.weight[lane] >= kAtCenter;
            if (out.edges_are_real) edge_points.add(i, out.edge_points);
        }
    }
    out.covered.resize(n_covered);
}

}  // namespace slim
