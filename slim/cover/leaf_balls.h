#pragma once

#include "slim/base/bbox.h"
#include "slim/base/simd.h"
#include "slim/base/unfilled_vector.h"
#include "slim/model/surfel.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// The balls of some leaves side by side, for those who ask again and again which of them meet a
/// box. Refers to the list of leaves it was made of.
class LeafBalls {
public:
    explicit LeafBalls(const std::vector<const Surfel*>& leaves) : leaves_(&leaves) {
        reserve(leaves.size());
        for (const Surfel* s : leaves) {
            x_[n_] = s->center.x, y_[n_] = s->center.y, z_[n_] = s->center.z;
            radius_[n_] = s->support_radius, index_[n_] = static_cast<std::uint32_t>(n_);
            ++n_;
        }
        pad();
    }

    std::size_t size() const { return n_; }
    const Surfel* operator[](std::size_t i) const { return (*leaves_)[index_[i]]; }

    /// Those whose balls meet a box, in their order: |p - c| < rho for one of its points p.
    /// Cost: O(size()), by lanes.
    [[gnu::flatten]] LeafBalls meeting(const Bbox& box) const {
        LeafBalls out(leaves_);
        out.reserve(n_);
        for (std::size_t i = 0; i < n_; i += Lanes::size()) {
            const Lanes x = at(x_, i), y = at(y_, i), z = at(z_, i), radius = at(radius_, i);
            const auto gap = [](const Lanes& c, double lo, double hi) {
                return stdx::max(stdx::max(lo - c, c - hi), Lanes(0));
            };
            const Lanes gx = gap(x, box.lo.x, box.hi.x), gy = gap(y, box.lo.y, box.hi.y),
                        gz = gap(z, box.lo.z, box.hi.z);
            const std::uint64_t near = lane_bits(gx * gx + gy * gy + gz * gz < radius * radius);
            const auto put = [&]<class V, class T>(const V& from, UnfilledVector<T>& to) {
                compress_to(from, near, &to[out.n_]);
            };
            put(x, out.x_), put(y, out.y_), put(z, out.z_), put(radius, out.radius_);
            put(LanesOfDouble<std::uint32_t>(&index_[i], stdx::element_aligned), out.index_);
            out.n_ += static_cast<std::size_t>(std::popcount(near));
        }
        out.pad();
        return out;
    }

private:
    using Lanes = stdx::native_simd<double>;

    explicit LeafBalls(const std::vector<const Surfel*>* leaves) : leaves_(leaves) {}
    static Lanes at(const UnfilledVector<double>& a, std::size_t i) {
        return {&a[i], stdx::element_aligned};
    }
    void reserve(std::size_t n) {
        for (UnfilledVector<double>* a : {&x_, &y_, &z_, &radius_}) a->resize(n + Lanes::size());
        index_.resize(n + Lanes::size());
    }
    /// The lanes after the last one: of no radius.
    void pad() {
        for (std::size_t i = n_; i < n_ + Lanes::size(); ++i)
            x_[i] = y_[i] = z_[i] = radius_[i] = 0, index_[i] = 0;
    }

    const std::vector<const Surfel*>* leaves_;
    UnfilledVector<double> x_, y_, z_, radius_;
    UnfilledVector<std::uint32_t> index_;  // in `leaves_`
    std::size_t n_ = 0;
};

/// Those of the others whose balls meet the box of some leaves' balls.
inline LeafBalls meeting(std::span<const Surfel* const> leaves, const LeafBalls& others) {
    Bbox box;
    for (const Surfel* s : leaves) {
        const Vec3d r{s->support_radius, s->support_radius, s->support_radius};
        box.extend(s->center - r), box.extend(s->center + r);
    }
    return others.meeting(box);
}

/// visit(first, some, near) for leaves that follow a curve, a few at a time: those from number
/// `first` on, and those of the others whose balls meet a box about theirs.
/// Cost: O(log(leaves)) lists of others that get shorter.
template <class Visit>
void for_leaves_together(std::span<const Surfel* const> leaves, const LeafBalls& others,
                         const Visit& visit, std::size_t first = 0) {
    constexpr std::size_t kTogether = 4;
    const LeafBalls near = meeting(leaves, others);
    if (leaves.size() <= kTogether) return visit(first, leaves, near);
    const std::size_t half = leaves.size() / 2;
    for_leaves_together(leaves.first(half), near, visit, first);
    for_leaves_together(leaves.subspan(half), near, visit, first + half);
}

/// Adds those others whose balls meet that of a leaf.
inline void append_meeting(const Surfel& leaf, const LeafBalls& others,
                           std::vector<const Surfel*>& out) {
    for (std::size_t i = 0; i < others.size(); ++i) {
        const Surfel* t = others[i];
        const double reach = leaf.support_radius + t->support_radius;
        if (t != &leaf && sq_length(t->center - leaf.center) < reach * reach) out.push_back(t);
    }
}

}  // namespace slim
