#include "slim/tree/drawn_hull.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <tuple>

namespace slim {
namespace {

/// Directions to places of a grid of 9 x 9 on each face of a cube.
constexpr int kHalf = 4;
constexpr std::size_t kDirections = 9 * 9 * 9 - 7 * 7 * 7;

struct Directions {
    std::array<double, kDirections> x, y, z;

    Directions() {
        std::size_t n = 0;
        for (int i = -kHalf; i <= kHalf; ++i)
            for (int j = -kHalf; j <= kHalf; ++j)
                for (int k = -kHalf; k <= kHalf; ++k) {
                    if (std::max({std::abs(i), std::abs(j), std::abs(k)}) < kHalf) continue;
                    const double inv = 1 / std::hypot(i, j, k);
                    x[n] = i * inv, y[n] = j * inv, z[n] = k * inv, ++n;
                }
    }
};

/// The farthest place found in each direction.
struct Farthest {
    std::array<double, kDirections> reach;
    std::array<Vec3d, kDirections> place;

    Farthest() { reach.fill(-INFINITY); }
    void add(const Directions& d, const Vec3d& p) {
        for (std::size_t k = 0; k < kDirections; ++k)
            if (const double r = d.x[k] * p.x + d.y[k] * p.y + d.z[k] * p.z; r > reach[k])
                reach[k] = r, place[k] = p;
    }
    void add(const Farthest& other) {
        for (std::size_t k = 0; k < kDirections; ++k)
            if (other.reach[k] > reach[k]) reach[k] = other.reach[k], place[k] = other.place[k];
    }
    /// Whether a ball may reach beyond what is found.
    bool may_grow(const Directions& d, const Vec3d& c, double radius) const {
        int n = 0;
        for (std::size_t k = 0; k < kDirections; ++k)
            n += d.x[k] * c.x + d.y[k] * c.y + d.z[k] * c.z + radius > reach[k];
        return n > 0;
    }
};

/// The place of sheet i over (u, v), drawn towards the middle until it is in the core; relative to
/// the centre and over rho.
Vec3d place_in_core(const Surfel& s, std::size_t i, double& u, double& v) {
    const auto at = [&] {
        return s.sheet_frame(i).world_from_local({u, v, s.sheet_polynomial(i).value(u, v)});
    };
    Vec3d x = at();
    constexpr int kMostPulls = 3;
    const double trim = hit_trim(s);
    for (int k = 0; k < kMostPulls && length(x) > trim; ++k) {
        const double pull = trim / length(x);
        u *= pull, v *= pull, x = at();
    }
    return x;
}

bool is_drawn(const Surfel& s, std::size_t sheet, const Vec3d& x, double u, double v) {
    if (!s.sharp) return rim_share(s.rims, u, v) > 0;
    return s.active_sheet(x) == sheet;
}

/// Places on what is drawn of a leaf, as seen from the frame's origin.
template <class Visit>
void for_places(const Surfel& s, const Visit& visit) {
    const auto place = [&](std::size_t sheet, double radius, double angle) {
        double u = radius * std::cos(angle), v = radius * std::sin(angle);
        const Vec3d x = place_in_core(s, sheet, u, v);
        if (is_drawn(s, sheet, x, u, v)) visit(s.center + x * s.support_radius);
    };
    const auto ring = [&](std::size_t sheet, double radius, int n) {
        for (int k = 0; k < n; ++k) place(sheet, radius, 2 * std::numbers::pi * k / n);
    };
    for (std::size_t sheet = 0; sheet < s.n_sheets(); ++sheet)
        ring(sheet, 0, 1), ring(sheet, hit_trim(s) / 2, 6), ring(sheet, hit_trim(s), 12);
}

Vec3d in_box(const Vec3d& p, const Bbox& box) {
    Vec3d out;
    for (std::size_t axis = 0; axis < 3; ++axis)
        out[axis] = std::clamp(p[axis], box.lo[axis], box.hi[axis]);
    return out;
}

Farthest search(const SurfelTree& tree, bool loose, const Bbox& box, const Directions& directions) {
    constexpr std::size_t kGrain = 4096;
    std::vector<Farthest> blocks((tree.n_nodes() + kGrain - 1) / kGrain);
    parallel_blocks(tree.n_nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
        Farthest& farthest = blocks[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            const TreeNode& node = tree.node(i);
            if (!node.is_leaf() || node.is_loose() != loose) continue;
            if (!farthest.may_grow(directions, tree.center(i), kHitTrim * tree.support_radius(i)))
                continue;
            for_places(tree.surfel(i),
                       [&](const Vec3d& p) { farthest.add(directions, in_box(p, box)); });
        }
    });
    Farthest all;
    for (const Farthest& block : blocks) all.add(block);
    return all;
}

/// Along an axis of the box the place moves onto its face.
Vec3d on_face(Vec3d p, const Vec3d& direction, const Bbox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (std::abs(direction[axis]) == 1)
            p[axis] = direction[axis] > 0 ? box.hi[axis] : box.lo[axis];
    return p;
}

}  // namespace

std::vector<Vec3d> drawn_hull(const SurfelTree& tree, bool loose, const Bbox& box) {
    const Directions directions;
    const Farthest farthest = search(tree, loose, box, directions);
    std::vector<Vec3d> hull;
    for (std::size_t k = 0; k < kDirections; ++k)
        if (farthest.reach[k] > -INFINITY) {
            const Vec3d direction{directions.x[k], directions.y[k], directions.z[k]};
            // The box with loose surfels is not theirs alone.
            hull.push_back(loose ? farthest.place[k] : on_face(farthest.place[k], direction, box));
        }
    const auto key = [](const Vec3d& p) { return std::tie(p.x, p.y, p.z); };
    std::sort(hull.begin(), hull.end(),
              [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
    hull.erase(std::unique(hull.begin(), hull.end()), hull.end());
    return hull;
}

}  // namespace slim
