#pragma once

#include "slim/base/vec.h"

#include <cstdint>
#include <vector>

namespace slim {

/// First and second moments of points about the first of them.
class PointMoments {
public:
    void add(const Vec3d& p) {
        if (!has_first_) first_ = p, has_first_ = true;
        const Vec3d d = p - first_;
        n_ += 1, x_ += d.x, y_ += d.y, z_ += d.z;
        xx_ += d.x * d.x, yy_ += d.y * d.y, zz_ += d.z * d.z;
        xy_ += d.x * d.y, xz_ += d.x * d.z, yz_ += d.y * d.z;
    }
    /// Whether all lie within a millionth of their extent of one line: such points have no surface.
    bool are_of_a_line() const;

private:
    bool has_first_ = false;
    Vec3d first_;
    double n_ = 0, x_ = 0, y_ = 0, z_ = 0, xx_ = 0, yy_ = 0, zz_ = 0, xy_ = 0, xz_ = 0, yz_ = 0;
};

/// How the points of a cloud lie: moments of all, and some thousand of them, taken evenly.
class CloudSpread {
public:
    void add(const Vec3d& p) {
        all_.add(p);
        if ((n_++ & (step_ - 1)) == 0) keep(p);
    }
    /// Whether the points lie on one line, as PointMoments has it, and not only because a few
    /// strays are so far away that the others are a speck.
    bool is_line() const { return all_.are_of_a_line() && middle_is_line(); }
    /// Whether they seem to for such strays alone.
    bool has_far_strays() const { return all_.are_of_a_line() && !middle_is_line(); }

private:
    void keep(const Vec3d& p);
    bool middle_is_line() const;

    PointMoments all_;
    std::uint64_t n_ = 0, step_ = 1;  // a power of two
    std::vector<Vec3d> sample_;       // every step_-th point
};

}  // namespace slim
