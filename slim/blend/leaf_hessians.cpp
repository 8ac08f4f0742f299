#include "slim/blend/leaf_hessians.h"

#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/blend/shape_field.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

namespace slim {
namespace {

using Nodes = std::vector<std::uint32_t>;

/// How far from its own centre a leaf looks for others', over rho.
constexpr double kReach = 2.5;
/// Cosine of two leaves' normals from which both may show one piece of surface.
constexpr double kLeastCosine = 0.5;
/// Steadies the least squares where few leaves stand around; over the sum of weights.
constexpr double kRidge = 0.02;
constexpr std::size_t kGrain = 64;
/// Leaves worked out together: with those around them some 30 MB.
constexpr std::size_t kMostAtOnce = 1 << 16;

/// Whether a node's second derivatives are bettered, and better others'.
bool is_bettered(const TreeNode& node) {
    return node.is_leaf() && !node.is_loose() && !(node.flags & kSharp) && node.degree == 2;
}

/// A leaf and what its own polynomial says.
struct LeafShape {
    Surfel surfel;
    PlanarTensor<2> mean;

    LeafShape(const SurfelTree& tree, std::uint32_t node)
        : surfel(tree.surfel(node)), mean(mean_shape_of(surfel.polynomial)) {}
};

/// Whether two leaves show one piece of surface: their normals agree, and neither lies farther off
/// the other's plane than a point that belongs to it.
bool go_together(const Surfel& a, const Surfel& b) {
    if (dot(a.frame.normal, b.frame.normal) < kLeastCosine) return false;
    const Vec3d both = a.frame.normal + b.frame.normal;
    return std::abs(dot(b.center - a.center, both)) <
           kBelongs * std::min(a.support_radius, b.support_radius) * length(both);
}

/// The axes of a's plane in those of b's, which the shortest turn from b's normal to a's moves.
PlaneTurn turn_between(const Frame<double>& b, const Frame<double>& a) {
    const double share = 1 / (1 + dot(a.normal, b.normal));
    const auto part = [&](const Vec3d& of_b, const Vec3d& of_a) {
        return dot(of_b, of_a) - share * dot(of_b, a.normal) * dot(b.normal, of_a);
    };
    return {part(b.u_axis, a.u_axis), part(b.v_axis, a.u_axis), part(b.u_axis, a.v_axis),
            part(b.v_axis, a.v_axis)};
}

/// Least squares for the slopes T of the shape operator at a leaf, from what it is at others:
/// sum w |S_j - S - T(d_j) - c|^2, with a ridge; the leaf itself counts, and c, which is not used,
/// keeps what is amiss with its S from showing as a slope where others stand on one side only. What
/// chance explains of the differences is taken off (as James and Stein do): where the others say
/// this and that, T is zero. All in the leaf's axes and over its rho.
class SlopeFit {
public:
    /// difference: S_j - S; (u, v): where
    void add(double w, double u, double v, const PlanarTensor<2>& difference) {
        weight_ += w, sq_weight_ += w * w, u_ += w * u, v_ += w * v;
        uu_ += w * u * u, uv_ += w * u * v, vv_ += w * v * v;
        for (std::size_t k = 0; k < 3; ++k) {
            const double wd = w * difference[k];
            d_[k] += wd, u_d_[k] += wd * u, v_d_[k] += wd * v, dd_[k] += wd * difference[k];
        }
    }

    /// Zeros from nothing.
    PlanarTensor<3> solve() const {
        PlanarTensor<3> right{};
        double sq_difference = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double n = n_times(2, k);
            right[k] += n * (u_d_[k] - u_ * d_[k] / weight_);
            right[k + 1] += n * (v_d_[k] - v_ * d_[k] / weight_);
            sq_difference += n * (dd_[k] - d_[k] * d_[k] / weight_);
        }
        PlanarTensor<3> out = solved(right);
        const double kept = kept_share(out, right, sq_difference);
        for (double& x : out) x *= kept;
        return out;
    }

private:
    /// The normal matrix is tridiagonal: entry k of T(d) is u T_k + v T_(k+1).
    PlanarTensor<3> solved(PlanarTensor<3> right) const {
        const double uu = uu_ - u_ * u_ / weight_, uv = uv_ - u_ * v_ / weight_,
                     vv = vv_ - v_ * v_ / weight_;
        PlanarTensor<3> diagonal{}, out{};
        PlanarTensor<2> beside{};
        for (std::size_t k = 0; k < 3; ++k) {
            const double n = n_times(2, k);
            diagonal[k] += n * uu, diagonal[k + 1] += n * vv, beside[k] = n * uv;
        }
        for (std::size_t k = 0; k < 4; ++k) diagonal[k] += n_times(3, k) * kRidge * weight_;
        for (std::size_t k = 1; k < 4; ++k) {
            const double share = beside[k - 1] / diagonal[k - 1];
            diagonal[k] -= share * beside[k - 1], right[k] -= share * right[k - 1];
        }
        out[3] = right[3] / diagonal[3];
        for (std::size_t k = 3; k-- > 0;)
            out[k] = (right[k] - beside[k] * out[k + 1]) / diagonal[k];
        return out;
    }
    /// max(0, 1 - 4 s^2 / explained) of the four slopes, s^2 what a difference keeps beside them
    /// and the three means.
    double kept_share(const PlanarTensor<3>& slopes, const PlanarTensor<3>& right,
                      double sq_difference) const {
        double explained = 0;
        for (std::size_t k = 0; k < 4; ++k) explained += slopes[k] * right[k];
        const double n = 3 * weight_ * weight_ / sq_weight_;
        if (!(explained > 0) || !(n > 7)) return 0;
        const double sq_rest = std::max(sq_difference - explained, 0.0) / (n - 7);
        return std::max(0.0, 1 - 4 * sq_rest / explained);
    }

    // The leaf itself: at (0, 0), no difference.
    double weight_ = 1, sq_weight_ = 1, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0, vv_ = 0;
    PlanarTensor<2> d_{}, u_d_{}, v_d_{}, dd_{};
};

/// A leaf's shape with the slopes that others tell.
class BetterShape {
public:
    explicit BetterShape(const LeafShape& leaf) : leaf_(leaf) {}

    void add(const LeafShape& other) {
        const Surfel &a = leaf_.surfel, &b = other.surfel;
        const Vec3d d = b.center - a.center;
        const double reach = a.support_radius + b.support_radius, sq = sq_length(d);
        if (!(sq < reach * reach) || !go_together(a, b)) return;
        const double ratio = a.support_radius / b.support_radius;  // S is over rho
        PlanarTensor<2> difference = turned<2>(other.mean, turn_between(b.frame, a.frame));
        for (std::size_t k = 0; k < 3; ++k) difference[k] = ratio * difference[k] - leaf_.mean[k];
        slopes_.add(weight_kernel(sq / (reach * reach)), dot(d, a.frame.u_axis) / a.support_radius,
                    dot(d, a.frame.v_axis) / a.support_radius, difference);
    }
    HeightHessian hessian() const {
        return hessian_of({leaf_.mean, slopes_.solve()}, leaf_.surfel.polynomial);
    }

private:
    const LeafShape& leaf_;
    SlopeFit slopes_;
};

/// Nodes of a tree that were looked at; threads may mark at the same time.
class Marks {
public:
    explicit Marks(std::size_t n) : marked_(n) {}
    void mark(std::uint32_t node) { marked_[node].store(true, std::memory_order_relaxed); }
    Nodes nodes() const {
        Nodes out;
        for (std::uint32_t i = 0; i < marked_.size(); ++i)
            if (marked_[i].load(std::memory_order_relaxed)) out.push_back(i);
        return out;
    }

private:
    std::vector<std::atomic<bool>> marked_;
};

/// Leaves whose centres lie near others.
class NearLeaves {
public:
    NearLeaves(const SurfelTree& tree, Marks& met) : tree_(tree), met_(met) {}

    /// Appends to `found` the leaves whose centres lie within kReach of a leaf and whose balls meet
    /// its own.
    void find(std::uint32_t leaf, Nodes& found) {
        const Vec3d c = tree_.center(leaf);
        const double rho = tree_.support_radius(leaf);
        stack_.assign(1, 0u);
        std::size_t visited = 0;
        while (!stack_.empty()) {
            const std::uint32_t i = stack_.back();
            stack_.pop_back();
            const TreeNode& node = tree_.node(i);
            if (node.n_children == 0) continue;
            const std::uint32_t n = node.n_children, first = node.first_child;
            if (first <= i || first >= tree_.n_nodes() || n > tree_.n_nodes() - first)
                throw FormatError("tree node " + std::to_string(i) +
                                  ": children must follow it inside the tree");
            if (++visited > tree_.n_nodes())
                throw FormatError("tree nodes: met more often than there are");
            for (std::uint32_t k = first; k < first + n; ++k) look_at(k, c, rho, found);
        }
    }

private:
    void look_at(std::uint32_t k, const Vec3d& c, double rho, Nodes& found) {
        const TreeNode& node = tree_.node(k);
        const bool is_leaf = is_bettered(node);
        if (!is_leaf && node.n_children == 0) return;
        const double far = is_leaf
                               ? std::min(kReach * rho, rho + tree_.support_radius(k))
                               : kReach * rho + static_cast<double>(node.bound_radius);
        if (!(sq_length(tree_.center(k) - c) < far * far)) return;
        met_.mark(k);
        (is_leaf ? found : stack_).push_back(k);
    }

    const SurfelTree& tree_;
    Marks& met_;
    Nodes stack_;
};

/// Leaves around some, one list after the other.
struct Around {
    Nodes of;
    std::vector<std::size_t> end;
};

std::vector<Around> leaves_around(const SurfelTree& tree, std::span<const std::uint32_t> nodes,
                                  Marks& met) {
    std::vector<Around> out((nodes.size() + kGrain - 1) / kGrain);
    parallel_blocks(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        NearLeaves near(tree, met);
        Around& around = out[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            met.mark(nodes[i]);
            near.find(nodes[i], around.of);
            around.end.push_back(around.of.size());
        }
    });
    return out;
}

/// Leaves by their nodes.
class LeafShapes {
public:
    LeafShapes(const SurfelTree& tree, const Nodes& nodes) : place_(tree.n_nodes()) {
        for (const std::uint32_t i : nodes) {
            if (!is_bettered(tree.node(i))) continue;
            place_[i] = static_cast<std::uint32_t>(shapes_.size());
            shapes_.emplace_back(tree, i);
        }
    }
    const LeafShape& of(std::uint32_t node) const { return shapes_[place_[node]]; }

private:
    std::vector<std::uint32_t> place_;
    std::vector<LeafShape> shapes_;
};

}  // namespace

struct LeafHessians::Page {
    std::array<HeightHessian, kSurfelsPerPage> hessian;
    std::array<bool, kSurfelsPerPage> known{};
};

LeafHessians::LeafHessians(const SurfelTree& tree)
    : tree_(tree), pages_((tree.n_nodes() + kSurfelsPerPage - 1) / kSurfelsPerPage) {}

LeafHessians::~LeafHessians() = default;

void LeafHessians::prepare(std::span<const std::uint32_t> nodes, const Met& met) {
    if (tree_.header().degree != 2) return;
    const std::lock_guard lock(preparing_);
    Nodes missing;
    for (const std::uint32_t i : nodes)
        if (is_bettered(tree_.node(i)) && !of(i)) missing.push_back(i);
    std::sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    for (std::size_t i = 0; i < missing.size(); i += kMostAtOnce)
        work_out(std::span(missing).subspan(i, std::min(kMostAtOnce, missing.size() - i)), met);
}

void LeafHessians::work_out(std::span<const std::uint32_t> missing, const Met& met) {
    Marks marks(tree_.n_nodes());
    const std::vector<Around> around = leaves_around(tree_, missing, marks);
    const Nodes looked_at = marks.nodes();
    if (met) met(looked_at);
    const LeafShapes shapes(tree_, looked_at);
    for (const std::uint32_t i : missing)
        if (std::unique_ptr<Page>& page = pages_[i / kSurfelsPerPage]; !page)
            page = std::make_unique<Page>();
    parallel_blocks(missing.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        const Around& a = around[begin / kGrain];
        std::size_t at = 0;
        for (std::size_t i = begin; i < end; ++i) {
            BetterShape shape(shapes.of(missing[i]));
            for (; at < a.end[i - begin]; ++at)
                if (a.of[at] != missing[i]) shape.add(shapes.of(a.of[at]));
            Page& page = *pages_[missing[i] / kSurfelsPerPage];
            page.hessian[missing[i] % kSurfelsPerPage] = shape.hessian();
            page.known[missing[i] % kSurfelsPerPage] = true;
        }
    });
}

void LeafHessians::prepare_all() {
    if (all_known_) return;
    Nodes nodes(tree_.n_nodes());
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<std::uint32_t>(i);
    prepare(nodes);
    all_known_ = true;
}

const HeightHessian* LeafHessians::of(std::uint32_t node) const {
    const Page* page = pages_[node / kSurfelsPerPage].get();
    const std::size_t i = node % kSurfelsPerPage;
    return page && page->known[i] ? &page->hessian[i] : nullptr;
}

}  // namespace slim
