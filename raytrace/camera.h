#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// A camera in the frame of the job: right-handed, looks along its -Z, +Y up; image origin top
/// left, pixel centres at +0.5 (CONVENTIONS 1.4).
struct Camera {
    Vec3d eye{0, 0, 1};
    Vec3d target{0, 0, 0};
    Vec3d up{0, 1, 0};
    bool orthographic = false;
    double fov_y_deg = 35;  ///< perspective: full angle, top to bottom
    double width = 1;       ///< orthographic: model units across the picture
    double near_plane = 0;  ///< camera z before which nothing is seen; 0: 1e-6 |target - eye|
};

/// Throws ConfigError naming the value: not finite, eye = target, nearer than 1e-150 or beyond
/// 1e150 from it, up zero or parallel to the view, angle outside (0, 180), width <= 0, near plane <
/// 0.
void validate(const Camera& camera);

/// The axis that named views hold upright.
enum class UpAxis { y, z, x, minus_y, minus_z, minus_x };

/// The axis as a unit vector.
Vec3d up_vector(UpAxis up);

/// Right, up and back (towards the eye) of the front view: east, up and south of a world with that
/// axis up.
std::array<Vec3d, 3> upright_axes(UpAxis up);

/// How named cameras frame it.
struct Framing {
    UpAxis up = UpAxis::y;      ///< z: terrain
    bool orthographic = false;
    double fov_y_deg = 35;
    double margin = 0.04;       ///< free border, as a share of the picture
    /// so many positions, turned about the up axis, stay in the picture (of more, 72 are looked at)
    int turns = 0;
    double free_right = 0;      ///< share of the picture's width kept for something else, [0, 0.9)
    double free_bottom = 0;     ///< and of its height
};

/// What named cameras frame: the convex hull of the points, or the box where there are none. A
/// turntable turns it about the box's middle.
struct Framed {
    Bbox box;
    std::span<const Vec3d> points = {};

    Framed(const Bbox& of, std::span<const Vec3d> hull = {}) : box(of), points(hull) {}
};

struct FramedCamera {
    Camera camera;
    /// From the axis to what is seen in the middle of the points' part of the picture: a camera
    /// that moves by 1 - 1 / zoom of it enlarges about that.
    Vec3d to_middle;
};

/// The camera "front", "back", "left", "right", "top", "bottom" or "iso" that frames the points in
/// a picture of the given aspect (width / height): as large as they fit, in its middle both ways.
/// `front` looks along -Z (with z or -z up: along +Y). With free_right (free_bottom) the camera
/// steps back and to the right (down), no more than the points need to stay out of that part; the
/// direction of view stays. Throws ConfigError on another name, listing these.
FramedCamera framed_camera(std::string_view name, const Framed& framed, double aspect,
                           const Framing& framing = {});

/// The camera alone.
Camera named_camera(std::string_view name, const Framed& framed, double aspect,
                    const Framing& framing = {});

/// True if named_camera knows the name.
bool is_camera_name(std::string_view name);
/// All of them: front, back, ...
const std::vector<std::string>& camera_names();

/// A camera with a picture's size: everything that projection needs, in doubles. Camera coordinates
/// are x right, y *down*, z along the view, so that they run with the pixels.
struct PixelView {
    Vec3d eye, right, down, forward;
    bool orthographic = false;
    double center_x = 0, center_y = 0;  ///< pixel coordinates of the axis
    double focal_px = 0;                ///< perspective: pixels per unit of x / z
    double px_per_unit = 0;             ///< orthographic: pixels per model unit
    double near_plane = 0;

    Vec3d camera_from_local(const Vec3d& p) const {
        const Vec3d d = p - eye;
        return {dot(right, d), dot(down, d), dot(forward, d)};
    }
    Vec3d rotate_to_camera(const Vec3d& d) const {
        return {dot(right, d), dot(down, d), dot(forward, d)};
    }
    Vec3d rotate_from_camera(const Vec3d& d) const {
        return right * d.x + down * d.y + forward * d.z;
    }
    /// Point on the ray of pixel coordinates (px, py) at camera z.
    Vec3d point_at(double px, double py, double z) const;
    /// Origin of the ray through (px, py): the eye, or its plane.
    Vec3d ray_origin(double px, double py) const;
    /// Unit direction of that ray.
    Vec3d ray_direction(double px, double py) const;
};

/// Checks the camera and fixes it for a picture of width x height pixels. Throws ConfigError also
/// on a size below 1.
PixelView pixel_view(const Camera& camera, int width, int height);

}  // namespace slim
