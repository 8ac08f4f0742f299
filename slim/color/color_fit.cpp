#include "slim/color/color_fit.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kPiece = 1 << 16;  ///< points whose shares are held at once
constexpr std::size_t kGrain = 1 << 10;
/// Added to the moments of the slopes, of the weight: of few points the slopes tend to zero.
constexpr double kDamping = 2e-3;

}  // namespace

ColorFit::ColorFit(const SurfelTree& tree) : tree_(tree), index_(tree), sums_(index_.n_leaves()) {}

void ColorFit::add_shares(const Vec3d& p, const Vec3f* normal, std::vector<const Surfel*>& found,
                          std::vector<Share>& shares) const {
    index_.supporters(p, found);
    for (const Surfel* s : found) {
        if (normal && dot(to_double(*normal), s->frame.normal) < 0) continue;
        const Vec3d x = (p - s->center) / s->support_radius;
        const Vec3d local = s->frame.local_from_world(x);
        shares.push_back({static_cast<std::uint32_t>(index_.number_of(s)),
                          static_cast<float>(weight_kernel(sq_length(x))),
                          static_cast<float>(local.x), static_cast<float>(local.y)});
    }
}

void ColorFit::add(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                   std::span<const Vec3f> colors) {
    SLIM_CHECK(colors.size(), ==, positions.size());
    SLIM_CHECK(normals.empty() || normals.size() == positions.size(), ==, true);
    std::vector<std::vector<Share>> blocks((kPiece + kGrain - 1) / kGrain);
    std::vector<std::vector<std::uint32_t>> ends(blocks.size());
    for (std::size_t first = 0; first < positions.size(); first += kPiece) {
        const std::size_t n = std::min(kPiece, positions.size() - first);
        // Which leaves hold a point is asked side by side; sums are made in the points' order.
        parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
            auto& shares = blocks[begin / kGrain];
            auto& last = ends[begin / kGrain];
            shares.clear(), last.clear();
            std::vector<const Surfel*> found;
            for (std::size_t i = first + begin; i < first + end; ++i) {
                add_shares(positions[i], normals.empty() ? nullptr : &normals[i], found, shares);
                last.push_back(static_cast<std::uint32_t>(shares.size()));
            }
        });
        for (std::size_t i = 0; i < n; ++i) {
            const auto& last = ends[i / kGrain];
            const std::size_t k = i % kGrain, from = k == 0 ? 0 : last[k - 1];
            n_lost_ += from == last[k];
            for (std::size_t j = from; j < last[k]; ++j) {
                const Share& s = blocks[i / kGrain][j];
                const double w = s.weight, u = s.u, v = s.v;
                Sums& sums = sums_[s.leaf];
                const double basis[3] = {w, w * u, w * v};
                sums.moments[0] += w, sums.moments[1] += w * u, sums.moments[2] += w * v;
                sums.moments[3] += w * u * u, sums.moments[4] += w * u * v,
                    sums.moments[5] += w * v * v;
                for (std::size_t b = 0; b < 3; ++b)
                    for (std::size_t c = 0; c < 3; ++c)
                        sums.colors[b][c] += basis[b] * static_cast<double>(colors[first + i][c]);
            }
        }
    }
}

/// About the weighted mean of (u, v): the mean colour stays exact whatever becomes of the slopes.
SurfelColor ColorFit::solve(const Sums& s) const {
    const double w = s.moments[0], u = s.moments[1] / w, v = s.moments[2] / w;
    const double damping = kDamping;
    const double uu = s.moments[3] / w - u * u + damping, uv = s.moments[4] / w - u * v;
    const double vv = s.moments[5] / w - v * v + damping, determinant = uu * vv - uv * uv;
    SurfelColor out;
    for (std::size_t c = 0; c < 3; ++c) {
        const double mean = s.colors[0][c] / w;
        const double cu = s.colors[1][c] / w - mean * u, cv = s.colors[2][c] / w - mean * v;
        const double du = (cu * vv - cv * uv) / determinant, dv = (cv * uu - cu * uv) / determinant;
        out.du[c] = static_cast<float>(du), out.dv[c] = static_cast<float>(dv);
        out.base[c] = static_cast<float>(mean - du * u - dv * v);
    }
    return out;
}

std::vector<SurfelColor> ColorFit::finish() const {
    const std::size_t n = tree_.n_nodes();
    std::vector<SurfelColor> colors(n);
    std::vector<double> weight(n, 0.0);
    for (std::size_t k = 0; k < sums_.size(); ++k) {
        if (!(sums_[k].moments[0] > 0)) continue;
        const std::size_t node = index_.node(k);
        colors[node] = solve(sums_[k]);
        weight[node] = std::max<double>(1, tree_.node(node).n_points);
    }
    // Children follow their parents: from the end every node is done before its parent asks.
    for (std::size_t i = n; i-- > 0;) {
        const TreeNode& node = tree_.node(i);
        if (node.is_leaf() || node.n_children == 0) continue;
        Vec3f sum;
        double total = 0;
        for (std::size_t child = node.first_child; child < node.first_child + node.n_children;
             ++child) {
            sum += colors[child].base * static_cast<float>(weight[child]);
            total += weight[child];
        }
        if (!(total > 0)) continue;
        colors[i].base = sum / static_cast<float>(total);
        weight[i] = total;
    }
    for (std::size_t i = 0; i < n; ++i) {
        const TreeNode& node = tree_.node(i);
        for (std::size_t child = node.first_child;
             node.n_children > 0 && child < node.first_child + node.n_children; ++child)
            if (!(weight[child] > 0)) colors[child].base = colors[i].base;
    }
    return colors;
}

}  // namespace slim
