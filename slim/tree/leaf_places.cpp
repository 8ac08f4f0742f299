#include "slim/tree/leaf_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace slim {
namespace {

/// Over the radius of the core.
struct OnDisc {
    double radius, cosine, sine;
};

std::array<OnDisc, kPlacesOfSheet> rings() {
    std::array<OnDisc, kPlacesOfSheet> out{};
    out[0] = {0, 1, 0};
    std::size_t at = 1;
    const auto ring = [&](double radius, int n) {
        for (int k = 0; k < n; ++k) {
            const double angle = 2 * std::numbers::pi * k / n;
            out[at++] = {radius, std::cos(angle), std::sin(angle)};
        }
    };
    ring(0.5, 6), ring(1, 12);
    return out;
}

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

void append(const Surfel& s, std::span<const OnDisc> some, std::vector<LeafPlace>& out) {
    const double core = hit_trim(s);
    for (std::size_t sheet = 0; sheet < s.n_sheets(); ++sheet)
        for (std::size_t k = 0; k < some.size(); ++k) {
            const double radius = some[k].radius * core;
            double u = radius * some[k].cosine, v = radius * some[k].sine;
            const Vec3d x = place_in_core(s, sheet, u, v);
            if (is_drawn(s, sheet, x, u, v))
                out.push_back({s.center + x * s.support_radius, sheet * kPlacesOfSheet + k});
        }
}

/// Share of a distance that covers the rounding of what is compared with it.
constexpr double kSlack = 1 + 1e-9;

}  // namespace

double most_height(const Polynomial<double>& p, double radius) {
    double height = 0, power = 1;
    std::size_t k = 0;
    for (std::size_t degree = 0; degree <= 3; ++degree, power *= radius)
        for (std::size_t n = 0; n <= degree; ++n) height += power * std::abs(p.a[k++]);
    return height;
}

void append_places(const Surfel& s, std::vector<LeafPlace>& out, std::size_t first) {
    static const std::array<OnDisc, kPlacesOfSheet> kRings = rings();
    append(s, std::span(kRings).first(first), out);
}

void append_close_places(const Surfel& s, std::vector<LeafPlace>& out) {
    constexpr std::size_t kRings = 4, kAngles = 96;
    constexpr int kSteps = 8;  // of a bisection
    const double core = hit_trim(s);
    for (std::size_t sheet = 0; sheet < s.n_sheets(); ++sheet)
        for (std::size_t k = 0; k < kAngles; ++k) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kAngles;
            const double cosine = std::cos(angle), sine = std::sin(angle);
            // Whether the sheet is drawn so far out; adds it.
            const auto adds = [&](double radius) {
                double u = radius * cosine, v = radius * sine;
                const Vec3d x = place_in_core(s, sheet, u, v);
                if (!is_drawn(s, sheet, x, u, v)) return false;
                out.push_back({s.center + x * s.support_radius, sheet * kPlacesOfSheet + k});
                return true;
            };
            double within = -1, without = -1;  // the farthest ring drawn, and the next one
            for (std::size_t ring = 1; ring <= kRings; ++ring) {
                const double radius = core * static_cast<double>(ring) / kRings;
                if (adds(radius)) within = radius, without = -1;
                else if (without < 0)
                    without = radius;
            }
            if (without < 0) continue;
            within = std::max(within, 0.0);
            for (int step = 0; step < kSteps; ++step) {
                const double middle = (within + without) / 2;
                (adds(middle) ? within : without) = middle;
            }
        }
}

LeafExtent::LeafExtent(const Surfel& s) : n_discs(s.n_sheets()) {
    const double core = hit_trim(s);
    for (std::size_t i = 0; i < n_discs; ++i)
        disc[i] = {s.sheet_frame(i).normal, kSlack * core * s.support_radius,
                   kSlack * most_height(s.sheet_polynomial(i), core) * s.support_radius};
}

Vec3d LeafExtent::along_axes() const {
    Vec3d out{0, 0, 0};
    for (std::size_t i = 0; i < n_discs; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double along = std::abs(disc[i].normal[axis]);
            out[axis] = std::max(out[axis], along * disc[i].height +
                                                std::sqrt(std::max(0.0, 1 - along * along)) *
                                                    disc[i].radius);
        }
    return out;
}

double radius_of_places(const SurfelTree& tree, std::size_t node) {
    double height = 0;
    if (tree.node(node).flags & kSharp) {
        const Surfel s = tree.surfel(node);
        for (std::size_t i = 0; i < s.n_sheets(); ++i)
            height = std::max(height, most_height(s.sheet_polynomial(i), kHitTrim));
    } else {
        const float* record = tree.record(node);
        const int n = floats_per_surfel(tree.record_degree(node));
        Polynomial<double> p{};
        for (int k = 6; k < n; ++k) p.a[static_cast<std::size_t>(k - 6)] = record[k];
        height = most_height(p, kHitTrim);
    }
    return kSlack * tree.support_radius(node) * std::sqrt(kHitTrim * kHitTrim + height * height);
}

}  // namespace slim
