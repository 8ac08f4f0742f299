#include "slim/edges/edge_leaf.h"

#include <bit>
#include <cmath>

namespace slim {
namespace {

constexpr int kSteps = 8;
constexpr double kSmallStep = 1e-10, kFarOff = 1.5;
// of a least sum of squares, which is reached more slowly where sheets do not meet in a point
constexpr double kSmallStepOfSum = 1e-4;
constexpr double kLeastVolume = 0.01;  // of the box of three unit normals
constexpr double kOneCorner = 0.1;     // sheets of one corner may pass by each other so far

/// The vector d with rows[k] . d = b[k]; nothing where the rows nearly lie in a plane.
std::optional<Vec3d> solved(const std::array<Vec3d, 3>& rows, const Vec3d& b, double least) {
    const Vec3d c0 = cross(rows[1], rows[2]), c1 = cross(rows[2], rows[0]),
                c2 = cross(rows[0], rows[1]);
    const double volume = dot(rows[0], c0);
    if (!(std::abs(volume) > least * length(rows[0]) * length(rows[1]) * length(rows[2])))
        return std::nullopt;
    return (c0 * b.x + c1 * b.y + c2 * b.z) * (1 / volume);
}

bool is_in(unsigned sheets, std::size_t k) { return (sheets >> k & 1u) != 0; }

/// Newton's step from x to where the three sheets are 0.
std::optional<Vec3d> step_of_three(const Surfel& s, const std::array<std::size_t, 3>& k,
                                   const Vec3d& x) {
    const Vec3d values{s.sheet_value(k[0], x), s.sheet_value(k[1], x), s.sheet_value(k[2], x)};
    return solved({s.sheet_gradient(k[0], x), s.sheet_gradient(k[1], x), s.sheet_gradient(k[2], x)},
                  values * -1.0, kLeastVolume);
}

/// Gauss and Newton's step to where the sum of the squares of those sheets is least.
std::optional<Vec3d> step_of_all(const Surfel& s, unsigned sheets, const Vec3d& x) {
    std::array<Vec3d, 3> rows{};
    Vec3d b;
    for (std::size_t k = 0; k < s.n_sheets(); ++k) {
        if (!is_in(sheets, k)) continue;
        const Vec3d g = s.sheet_gradient(k, x);
        rows[0] += g * g.x, rows[1] += g * g.y, rows[2] += g * g.z;
        b += g * -s.sheet_value(k, x);
    }
    return solved(rows, b, kLeastVolume * kLeastVolume);
}

/// Where such steps from the centre come to rest, near the ball.
template <class Step>
std::optional<Vec3d> place_at_rest(double small, Step&& step) {
    Vec3d x;
    for (int i = 0; i < kSteps; ++i) {
        const std::optional<Vec3d> d = step(x);
        if (!d) return std::nullopt;
        x += *d;
        if (!(sq_length(x) < kFarOff * kFarOff)) return std::nullopt;
        if (sq_length(*d) < small * small) return x;
    }
    return std::nullopt;
}

/// The sheets that pass by x no farther than others of one corner may.
unsigned sheets_at(const Surfel& s, const Vec3d& x) {
    unsigned sheets = 0;
    for (std::size_t k = 0; k < s.n_sheets(); ++k)
        if (std::abs(s.sheet_value(k, x)) < kOneCorner) sheets |= 1u << k;
    return sheets;
}

/// Whether no other sheet cuts off the place where those meet.
bool corner_shows(const Surfel& s, unsigned sheets, const Vec3d& x) {
    std::array<double, kMostSheets> f = s.sheet_values(x);
    for (std::size_t k = 0; k < s.n_sheets(); ++k)
        if (is_in(sheets, k)) f[k] = 0;
    return std::abs(s.sharp->joined(f)) <= kEdgeTolerance;
}

/// The corner where three sheets meet, with those that pass by it.
std::optional<LeafCorner> corner_of_three(const Surfel& s, const std::array<std::size_t, 3>& k) {
    const auto x =
        place_at_rest(kSmallStep, [&](const Vec3d& at) { return step_of_three(s, k, at); });
    if (!x) return std::nullopt;
    const unsigned sheets = sheets_at(s, *x);
    if (std::popcount(sheets) == 3) return LeafCorner{*x, sheets};
    const auto nearest =
        place_at_rest(kSmallStepOfSum, [&](const Vec3d& at) { return step_of_all(s, sheets, at); });
    if (!nearest) return std::nullopt;
    return LeafCorner{*nearest, sheets};
}

/// Adds a corner, or its sheets to the one that is there.
void add_corner(const LeafCorner& corner, std::vector<LeafCorner>& out) {
    for (LeafCorner& known : out)
        if (sq_length(known.x - corner.x) < kOneCorner * kOneCorner) {
            known.sheets |= corner.sheets;
            return;
        }
    out.push_back(corner);
}

}  // namespace

std::optional<Vec3d> nearest_on_edge(const Surfel& s, const SheetPair& pair, Vec3d x) {
    constexpr double kLeastSqSine = 0.01;
    for (int step = 0; step < kSteps; ++step) {
        const Vec3d ga = s.sheet_gradient(pair.a, x), gb = s.sheet_gradient(pair.b, x);
        const double fa = s.sheet_value(pair.a, x), fb = s.sheet_value(pair.b, x);
        // The step d = p ga + q gb with ga . d = -fa, gb . d = -fb.
        const double aa = sq_length(ga), ab = dot(ga, gb), bb = sq_length(gb),
                     det = aa * bb - ab * ab;
        if (!(det > kLeastSqSine * aa * bb)) return std::nullopt;
        const Vec3d d = ga * ((ab * fb - bb * fa) / det) + gb * ((ab * fa - aa * fb) / det);
        x += d;
        if (!(sq_length(x) < kFarOff * kFarOff)) return std::nullopt;
        if (sq_length(d) < kSmallStep * kSmallStep) return x;
    }
    return std::nullopt;
}

std::vector<LeafCorner> corners_of(const Surfel& s) {
    std::vector<LeafCorner> out;
    for (std::size_t c = 2; c < s.n_sheets(); ++c)
        for (std::size_t b = 1; b < c; ++b)
            for (std::size_t a = 0; a < b; ++a) {
                const auto corner = corner_of_three(s, {a, b, c});
                if (!corner || !(sq_length(corner->x) < 1)) continue;
                if (corner_shows(s, corner->sheets, corner->x)) add_corner(*corner, out);
            }
    return out;
}

bool edge_shows(const Surfel& s, const SheetPair& pair, const Vec3d& x) {
    if (s.n_sheets() == 2) return true;
    std::array<double, kMostSheets> f = s.sheet_values(x);
    f[pair.a] = f[pair.b] = 0;
    return std::abs(s.sharp->joined(f)) <= kEdgeTolerance;
}

}  // namespace slim
