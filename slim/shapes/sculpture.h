#pragma once

#include "slim/shapes/blend.h"

namespace slim {

/// A winged figure on a stepped pedestal, y up, about two units tall (after the Nike of Samothrace,
/// much simplified): drapery, thin wings with engraved feathers and sharp rims, an arm that encloses
/// a hole, braided hair, flat faces and sharp edges of the base.
struct SculptureShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        const T base = pedestal(p);
        return sharp_min(base, figure(p));
    }

private:
    /// Two blocks and a round moulding; creases at every edge.
    template <class T>
    static T pedestal(const Vec3<T>& p) {
        const T plinth = box(moved(p, 0, -0.93, 0), {0.46, 0.07, 0.46});
        const T block = box(moved(p, 0, -0.76, 0), {0.36, 0.12, 0.36});
        const Vec3<T> q{p.x, p.z, p.y + 0.64};
        const T moulding = torus_z(q, 0.3, 0.045);
        const T disc = sharp_max(T(hypot2(p.x, p.z) - 0.3), T(absolute(p.y + 0.64) - 0.045));
        return sharp_min(sharp_min(plinth, block), sharp_min(moulding, disc));
    }

    template <class T>
    static T figure(const Vec3<T>& p) {
        T f = smooth_min(robe(p), torso(p), 0.05);
        f = smooth_min(f, arms(p), 0.03);
        f = sharp_min(f, belt(p));
        f = smooth_min(f, head(p), 0.03);
        return smooth_min(f, wings(p), 0.025);
    }

    /// A flaring skirt whose radius carries folds, deeper towards the hem and turning with height.
    template <class T>
    static T robe(const Vec3<T>& p) {
        using std::atan2;
        using std::cos;
        using std::sqrt;
        const T x = p.x, z = p.z + 0.10 * square(T(p.y - 0.1));
        const T sq_r = square(x) + square(z);
        const T r = sqrt(sq_r + 1e-4);
        const T angle = atan2(x, z);
        const T depth = fade_in(T(-p.y), 0.12, 0.25) * sq_r / (sq_r + 0.02);
        const T turn = 1.6 * p.y;
        const T folds = 0.55 * cos(T(9.0 * angle + 3.0 * turn + 0.8 * cos(T(2.0 * angle + turn)))) +
                        0.30 * cos(T(5.0 * angle - 2.0 * turn + 1.0));
        const T flare = 0.155 + 0.055 * square(T(p.y - 0.2)) +
                        0.10 * fade_in(T(-p.y), 0.42, 0.13);
        const T side = (r - flare - 0.045 * depth * folds) * 0.9;
        const T hem = -0.61 - p.y;
        return smooth_max(smooth_max(side, hem, 0.015), T(p.y - 0.30), 0.06);
    }

    template <class T>
    static T torso(const Vec3<T>& p) {
        const T chest = ellipsoid(moved(p, 0, 0.38, 0.01), {0.165, 0.20, 0.115});
        const T shoulders =
            tapered_capsule(p, {-0.13, 0.50, 0.0}, {0.13, 0.50, 0.0}, 0.062, 0.062);
        const T neck = tapered_capsule(p, {0, 0.50, 0.0}, {0, 0.68, 0.015}, 0.055, 0.045);
        return smooth_min(smooth_min(chest, shoulders, 0.05), neck, 0.035);
    }

    template <class T>
    static T belt(const Vec3<T>& p) {
        const Vec3<T> q{p.x, p.z, p.y - 0.14};
        const T ring = hypot2(T(hypot2(q.x, q.y) - 0.168), T(0.0 * q.x)) - 0.018;
        return sharp_max(ring, T(absolute(q.z) - 0.03));
    }

    /// The right arm is raised; the left rests on the hip and leaves a hole.
    template <class T>
    static T arms(const Vec3<T>& p) {
        const T raised = smooth_min(
            tapered_capsule(p, {0.17, 0.50, 0.0}, {0.33, 0.62, 0.10}, 0.050, 0.042),
            tapered_capsule(p, {0.33, 0.62, 0.10}, {0.36, 0.86, 0.16}, 0.042, 0.032), 0.02);
        const T akimbo = smooth_min(
            tapered_capsule(p, {-0.17, 0.50, 0.0}, {-0.36, 0.33, 0.03}, 0.050, 0.042),
            tapered_capsule(p, {-0.36, 0.33, 0.03}, {-0.18, 0.15, 0.08}, 0.042, 0.036), 0.02);
        return sharp_min(raised, akimbo);
    }

    /// An egg with a sharp-edged face cut, engraved hair fading in towards the back.
    template <class T>
    static T head(const Vec3<T>& p) {
        using std::cos;
        Vec3<T> q = moved(p, 0, 0.80, 0.02);
        rotate(q.y, q.z, 0.15);
        const T back = fade_in(T(-q.z + 0.6 * q.y), 0.02, 0.03);
        const T hair = 0.004 * back * cos(T(110.0 * (q.y + 0.5 * q.z) + 6.0 * cos(T(12.0 * q.x))));
        const T skull = ellipsoid(q, {0.098, 0.130, 0.112}) + hair;
        const T bun = norm(moved(q, 0, 0.03, -0.13)) - 0.055 + hair;
        const T face = sharp_max(T(0.9 * q.z + 0.43 * q.x - 0.088), T(0.9 * q.z - 0.43 * q.x - 0.088));
        return smooth_min(sharp_max(skull, face), bun, 0.015);
    }

    /// Thin lens-like plates: sharp rim where two sheets meet, feathers engraved as waves.
    template <class T>
    static T wings(const Vec3<T>& p) {
        using std::cos;
        using std::sqrt;
        Vec3<T> q{sqrt(square(p.x) + 0.0004), p.y - 0.50, p.z + 0.09};
        rotate(q.x, q.z, 0.75);
        const T span = q.x, lift = q.y - 0.55 * q.x - 0.25 * square(q.x);
        const T bend = q.z - 0.18 * square(q.x) - 0.12 * square(q.y);
        const T outline = 0.62 * (hypot2(T((span - 0.40) / 0.46), T((lift + 0.02) / 0.24)) - 1.0) * 0.24;
        const T feather_fade = fade_in(T(span - 0.5 * lift), 0.32, 0.08);
        const T feathers = 0.005 * feather_fade * cos(T(75.0 * (lift + 0.35 * square(span))));
        const T thick = absolute(bend) - 0.028 + 0.0 * span;
        const T sheet = thick + feathers;
        return 0.75 * sharp_max(sheet, T(outline + 0.35 * absolute(bend)));
    }
};

}  // namespace slim
