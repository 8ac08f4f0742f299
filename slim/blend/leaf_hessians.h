#pragma once

#include "slim/model/height_hessian.h"
#include "slim/model/surfel_tree.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace slim {

/// Second derivatives of quadratic leaves, one degree better than their own polynomials: what
/// curvature is blended of (notes/0001).
///
/// A quadric was fitted to its ball as a whole, and its second derivatives hold of the ball's mean.
/// That they are the same all over it, so that curvature falls as slopes rise, is a consequence of
/// its degree, not of the points. Here the shape operator is what a leaf knows, its mean over the
/// ball. Its slopes come from the leaves around, by least squares under the blend's own weights.
/// So a sphere, a cylinder and the k1 of a torus tube are the same all over a leaf, as they are.
class LeafHessians {
public:
    /// Gets nodes that are looked at before their surfels are.
    using Met = std::function<void(std::span<const std::uint32_t>)>;

    /// Says nothing of any leaf yet. The tree's arrays must outlive this.
    explicit LeafHessians(const SurfelTree& tree);
    ~LeafHessians();

    /// Works out those of some nodes that are not known yet: smooth leaves of degree 2 that are not
    /// loose, in models of degree 2. Others have none. The same for any order of calls. One call at
    /// a time works, others wait; not from within parallel work that one of these waits for.
    /// throws  FormatError for a tree with cycles
    /// cost    5 to 10 us of processor time a leaf, in parallel; 72 bytes a node of the pages of
    ///         1,024 nodes that these lie in
    void prepare(std::span<const std::uint32_t> nodes, const Met& met = {});
    /// Of all leaves; no work if they are known.
    void prepare_all();

    /// Of a node that was prepared; null: that of its own polynomial. Stays where it is.
    const HeightHessian* of(std::uint32_t node) const;

private:
    struct Page;
    void work_out(std::span<const std::uint32_t> missing, const Met& met);

    SurfelTree tree_;
    std::vector<std::unique_ptr<Page>> pages_;
    std::mutex preparing_;
    std::atomic<bool> all_known_ = false;
};

}  // namespace slim
