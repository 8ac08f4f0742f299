#pragma once

#include "raytrace/narrow_backs.h"
#include "raytrace/shade.h"
#include "raytrace/trace/light_pass.h"
#include "tests/raytrace/support/like_brute.h"

#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

// What the tests of light by rays share: a view of a model of good surfels, and lights.

namespace slim::test {


inline constexpr int kSize = 120;

/// Surfels of a sphere whose fit errors are those of a good fit.
inline SurfelTreeData good_model(std::vector<Surfel> leaves) {
    auto model = test::flat_tree(std::move(leaves), 2);
    for (TreeNode& node : model.nodes) node.fit_error = 1e-4f;
    return model;
}
inline SurfelTreeData good_sphere() { return good_model(test::sphere_leaves(1, 600, 6, 2)); }

/// A view, what it sees of a model, and a look.
struct Stage {
    SurfelTreeData data;
    SurfelTree tree;
    TraceScene scene;
    Camera camera;
    PixelView view;
    ShadeView shade;
    GBuffer buffer;
    TracedPlanes traced;
    std::array<std::vector<float>, 3> normals;
    std::vector<float> narrow;
    TraceLook look;
    mutable TraceCounts counts;

    /// `more` models stand beside it; their trees must outlive the stage.
    explicit Stage(SurfelTreeData model, const Camera& from, int size = kSize,
                   std::vector<ScenePart> more = {})
        : data(std::move(model)),
          tree(data.view()),
          scene(parts(tree, std::move(more)), false),
          camera(from),
          view(pixel_view(camera, size, size)) {
        const double px = view.orthographic ? view.px_per_unit : view.focal_px;
        shade = {view.right,      -view.down,      -view.forward,
                 size / (2 * px), size / (2 * px), view.orthographic};
        RenderRequest request{camera, size, size, kPositionChannel | kNormalChannel, 0, {}, false};
        render_traced(scene, request, buffer, &traced);
        const NormalPlanes own{buffer.normal[0], buffer.normal[1], buffer.normal[2]};
        normals = turned_normals(size, size, shade, own, buffer.hit);
        narrow = narrow_backs(size, size, shade, own, buffer.hit);
        look.rig.up = shade.up;
        look.rig.sky = look.rig.ground = {};
    }

    static std::vector<ScenePart> parts(const SurfelTree& first, std::vector<ScenePart> more) {
        more.insert(more.begin(), {&first, {}});
        return more;
    }
    TracedSurface surface() const {
        return {scene, {view, {0, 0, buffer.width, buffer.height}, buffer, normals}, traced,
                narrow};
    }
    Picture light() const { return light_rows(surface(), look, {}, {0, buffer.height}, counts); }
    std::vector<float> openness(double distance, int samples) const {
        return openness_plane(surface(), {distance, samples}, look.ground, counts);
    }
    Vec3d normal(std::size_t i) const { return {normals[0][i], normals[1][i], normals[2][i]}; }
    Vec3d position(std::size_t i) const {
        return {buffer.position[0][i], buffer.position[1][i], buffer.position[2][i]};
    }
    Vec3d direction(std::size_t i) const {
        const auto w = static_cast<std::size_t>(buffer.width);
        return view.ray_direction(static_cast<double>(i % w) + 0.5,
                                  static_cast<double>(i / w) + 0.5);
    }
    Vec3d eye(std::size_t i) const {
        const auto w = static_cast<std::size_t>(buffer.width);
        return view.ray_origin(static_cast<double>(i % w) + 0.5, static_cast<double>(i / w) + 0.5);
    }
};

inline Camera camera_at(const Vec3d& eye, const Vec3d& target, double fov = 40) {
    Camera camera;
    camera.eye = eye, camera.target = target, camera.fov_y_deg = fov;
    return camera;
}

inline LightSource sun(const Vec3d& toward) {
    LightSource light;
    light.toward = normalized(toward);
    light.highlight = 0;
    return light;
}

inline bool meets_sphere(const Vec3d& p, const Vec3d& d, double radius) {
    const double along = -dot(p, d);
    return along > 0 && sq_length(p + d * along) < radius * radius;
}

inline Picture without_shadows(Stage& stage) {
    stage.look.shadows = false;
    const Picture out = stage.light();
    stage.look.shadows = true;
    return out;
}

/// A ground of pure shadow under the unit sphere, from above.
inline Stage sphere_on_ground() {
    Stage stage(good_sphere(), camera_at({0, 9, 4}, {0.7, -1, 0}));
    stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    return stage;
}

/// Calls check(pixel, point) for pixels that see the ground.
inline void for_ground(const Stage& stage,
                       const std::function<void(std::size_t, const Vec3d&)>& check) {
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
        if (stage.buffer.hit[i]) continue;
        const Vec3d d = stage.direction(i), o = stage.eye(i);
        if (d.y < -0.01) check(i, o + d * ((-1 - o.y) / d.y));
    }
}

}  // namespace slim::test
