#pragma once

#include "slim/shapes/blend.h"

namespace slim {

/// A winged figure on a stepped pedestal, y up, about two units tall (after the Nike of Samothrace,
/// much simplified): drapery, thin wings with engraved feathers and sharp rims, an arm that
/// encloses a hole, engraved hair, a tunic's sharp hem, flat faces and edges of the base.
///
/// Further than kFar from a part's bounding box the distance to the box stands for the part (it is
/// no more than that to the part): cheaper, and no change to the surface, because parts blend over
/// less than the value that they have there. So f jumps where it is large, never near the surface.
struct SculptureShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        T f = smooth_min(robe(p), torso(p), 0.07);
        f = smooth_min(f, arms(p), 0.05);
        f = smooth_min(f, head(p), 0.04);
        f = smooth_min(f, wings(p), 0.04);
        return sharp_min(pedestal(p), f);
    }

private:
    static constexpr double kFar = 0.12;

    /// Two blocks and a round moulding; creases at every edge.
    template <class T>
    static T pedestal(const Vec3<T>& p) {
        const T plinth = box(moved(p, 0, -0.93, 0), {0.46, 0.07, 0.46});
        const T block = box(moved(p, 0, -0.76, 0), {0.36, 0.12, 0.36});
        const T rho = hypot2(p.x, p.z), y = p.y + 0.64;
        const T moulding = hypot2(T(rho - 0.31), y) - 0.04;
        const T disc = sharp_max(T(rho - 0.31), T(absolute(y) - 0.04));
        return sharp_min(sharp_min(plinth, block), sharp_min(moulding, disc));
    }

    /// A flaring skirt whose radius carries folds, deeper towards the hem and turning with height;
    /// over it a shorter tunic with a wavy, sharp hem, and a sash.
    template <class T>
    static T robe(const Vec3<T>& p) {
        using std::atan2;
        using std::cos;
        using std::sqrt;
        const T far = box(moved(p, 0, -0.15, 0), {0.36, 0.47, 0.38});
        if (value_of(far) > kFar) return far;
        const T x = p.x - 0.10 * square(T(p.y + 0.15)), z = p.z + 0.10 * square(T(p.y - 0.1));
        const T sq_r = square(x) + square(z);
        const T r = sqrt(sq_r + 1e-4);
        const T angle = atan2(x, z);
        const T turn = 1.5 * p.y;
        // Round ridges, narrow valleys: a smoothed |cos|; a second, slower wave breaks the order.
        const T wave = cos(T(5.5 * angle + 2.0 * turn + 0.7 * cos(T(2.0 * angle + turn))));
        const T ridges = sqrt(square(wave) + 0.04) - 0.6;
        const T folds = ridges + 0.35 * cos(T(3.0 * angle - 2.0 * turn + 1.0));
        const T depth = fade_in(T(-p.y), 0.10, 0.16) * sq_r / (sq_r + 0.01);
        const T flare =
            0.150 + 0.04 * square(T(p.y - 0.2)) + 0.13 * fade_in(T(-p.y), 0.40, 0.14);
        const T skirt = r - flare - 0.063 * depth * folds;
        const T hem = 0.05 + 0.035 * cos(T(3.0 * angle + 0.5)) + 0.3 * x;
        const T pleats = 0.006 * cos(T(22.0 * angle + 4.0 * turn)) * fade_in(T(-p.y), -0.10, 0.04) *
                         sq_r / (sq_r + 0.01);
        const T tunic = sharp_max(T(skirt - 0.022 - pleats), T(0.7 * (-p.y - hem)));
        const T sash = sharp_max(T(r - 0.182), T(absolute(T(p.y - 0.155 - 0.2 * x)) - 0.02));
        const T cloth = smooth_max(T(0.85 * sharp_min(skirt, tunic)), T(p.y - 0.30), 0.12);
        return smooth_max(sharp_min(cloth, sash), T(-0.61 - p.y), 0.02);
    }

    template <class T>
    static T torso(const Vec3<T>& p) {
        const T far = box(moved(p, 0, 0.45, 0), {0.22, 0.28, 0.14});
        if (value_of(far) > kFar) return far;
        const T chest = ellipsoid(moved(p, 0, 0.36, 0.01), {0.165, 0.22, 0.120});
        const T shoulders =
            tapered_capsule(p, {-0.13, 0.50, 0.0}, {0.13, 0.50, 0.0}, 0.060, 0.060);
        const T neck = tapered_capsule(p, {0, 0.50, 0.0}, {0, 0.68, 0.015}, 0.055, 0.045);
        return smooth_min(smooth_min(chest, shoulders, 0.12), neck, 0.07);
    }

    /// The left arm is raised; the right one rests on the hip and leaves a hole.
    template <class T>
    static T arms(const Vec3<T>& p) {
        return sharp_min(raised_arm(p), arm_on_hip(p));
    }

    template <class T>
    static T raised_arm(const Vec3<T>& p) {
        const T far = box(moved(p, 0.27, 0.68, 0.07), {0.17, 0.25, 0.15});
        if (value_of(far) > kFar) return far;
        const T upper = tapered_capsule(p, {0.16, 0.50, 0.0}, {0.33, 0.60, 0.10}, 0.052, 0.043);
        const T lower = tapered_capsule(p, {0.33, 0.60, 0.10}, {0.37, 0.86, 0.15}, 0.043, 0.028);
        return smooth_min(upper, lower, 0.04);
    }

    template <class T>
    static T arm_on_hip(const Vec3<T>& p) {
        const T far = box(moved(p, -0.26, 0.33, 0.04), {0.18, 0.25, 0.12});
        if (value_of(far) > kFar) return far;
        const T upper = tapered_capsule(p, {-0.16, 0.50, 0.0}, {-0.37, 0.34, 0.02}, 0.052, 0.042);
        const T lower = tapered_capsule(p, {-0.37, 0.34, 0.02}, {-0.17, 0.17, 0.08}, 0.042, 0.032);
        return smooth_min(upper, lower, 0.04);
    }

    /// An egg with two facets that meet in the ridge of the nose, and engraved hair that fades in
    /// towards the back and the knot.
    template <class T>
    static T head(const Vec3<T>& p) {
        using std::cos;
        const T far = box(moved(p, 0, 0.80, -0.02), {0.12, 0.16, 0.19});
        if (value_of(far) > kFar) return far;
        Vec3<T> q = moved(p, 0, 0.80, 0.02);
        rotate(q.y, q.z, 0.15);
        const T back = fade_in(T(-q.z + 0.7 * q.y), 0.015, 0.02);
        const T waves = cos(T(150.0 * (q.y + 0.6 * q.z) + 5.0 * cos(T(14.0 * q.x))));
        const T hair = 0.0028 * back * waves - 0.006 * back;
        const T skull = ellipsoid(q, {0.094, 0.128, 0.108}) + hair;
        const T knot = norm(moved(q, 0, 0.04, -0.125)) - 0.050 + hair;
        const T face =
            sharp_max(T(0.9 * q.z + 0.42 * q.x - 0.091), T(0.9 * q.z - 0.42 * q.x - 0.091));
        return smooth_min(smooth_max(skull, face, 0.012), knot, 0.03);
    }

    /// Thin curved plates with sharp rims, mirrored in x; feathers engraved as waves that grow
    /// towards the tips.
    template <class T>
    static T wings(const Vec3<T>& p) {
        using std::cos;
        using std::sqrt;
        const T far = box(moved(p, 0, 0.68, -0.25), {0.77, 0.54, 0.36});
        if (value_of(far) > kFar) return far;
        Vec3<T> q{sqrt(square(p.x) + 0.0004), p.y - 0.50, p.z + 0.09};
        rotate(q.x, q.z, 0.75);
        const T span = q.x, lift = q.y - 0.55 * q.x - 0.25 * square(q.x);
        const T bend = q.z - 0.18 * square(q.x) - 0.12 * square(q.y);
        const T rim =
            0.15 * (hypot2(T((span - 0.40) / 0.46), T((lift + 0.02) / 0.24)) - 1.0);
        const T thick = absolute(bend) - 0.026;
        const T plate = sharp_max(thick, T(rim + 0.35 * absolute(bend)));
        if (value_of(plate) > kFar) return 0.75 * (plate - 0.006);
        const T fade = fade_in(T(span - 0.5 * lift), 0.30, 0.08);
        const T feathers = fade * (0.0045 * cos(T(80.0 * (lift + 0.35 * square(span)))) +
                                   0.0012 * cos(T(260.0 * (0.55 * lift + 0.5 * span))));
        return 0.75 * sharp_max(T(thick + feathers), T(rim + 0.35 * absolute(bend)));
    }
};

}  // namespace slim
