#include "pipeline/render/render_shadings.h"

#include "formats/image_io.h"
#include "pipeline/contains.h"
#include "pipeline/render/relief_options.h"
#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_colors.h"
#include "pipeline/render/render_contours.h"
#include "raytrace/stripes.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr Vec3f kClay{0.690f, 0.632f, 0.572f};
constexpr float kGloss = 0.09f;

std::array<Vec3f, 3> float_axes(const std::array<Vec3d, 3>& axes) {
    return {to_float(axes[0]), to_float(axes[1]), to_float(axes[2])};
}

Relief relief_of(const RenderConfig& config, const ModelHeader& model) {
    const std::array<Vec3d, 3> axes = upright_axes(up_axis(config));
    Relief relief{float_axes(axes), dot(axes[1], model.origin), config.sun[0], config.sun[1], 0};
    relief.spacing = fixed_spacing(config).value_or(0);
    return relief;
}

/// Calls color(normal, toward_eye) -> linear light at each hit of some rows; vectors in camera
/// axes.
template <class Color>
Picture paint_rows(const RenderedFrame& frame, const RowRange& rows, const Color& color) {
    const GBuffer& b = frame.buffer;
    Picture out(b.width, rows.end - rows.begin);
    for_eye_rows(b.width, b.height, rows, frame.view, {b.normal[0], b.normal[1], b.normal[2]},
                 b.hit, [&](const EyeRow& row) {
                     for (int x = 0; x < b.width; ++x) {
                         const auto k = static_cast<std::size_t>(x);
                         if (!row.hit[k]) continue;
                         const Vec3f c = color(row.normal[k], row.toward_eye[k]);
                         float* p = out.pixel(x, row.y - rows.begin);
                         p[0] = c.x, p[1] = c.y, p[2] = c.z, p[3] = 1;
                     }
                 });
    return out;
}

Picture paint_environment(const Environment& light, const RenderedFrame& frame,
                          const RowRange& rows) {
    const ShadeView& v = frame.view;
    const Vec3f right = to_float(v.right), up = to_float(v.up), back = to_float(v.back);
    const auto in_world = [&](const Vec3f& d) { return right * d.x + up * d.y + back * d.z; };
    return paint_rows(frame, rows, [&](const Vec3f& n, const Vec3f& e) {
        const Vec3f diffuse = light.diffuse(in_world(n));
        const Vec3f glossy = light.glossy(in_world(n * (2 * dot(n, e)) - e));
        return Vec3f{kClay.x * diffuse.x, kClay.y * diffuse.y, kClay.z * diffuse.z} +
               glossy * kGloss;
    });
}

}  // namespace

bool is_shading(const std::string& aov) {
    return aov == "environment" || aov == "matcap" || aov == "reflection" || aov == "hillshade" ||
           aov == "color";
}

bool is_color(const std::string& aov) { return aov == "shaded" || is_shading(aov); }

ShadingInputs load_shadings(const RenderConfig& config, const std::vector<std::string>& aovs,
                            const ModelHeader& model) {
    ShadingInputs inputs;
    const std::array<Vec3d, 3> axes = upright_axes(up_axis(config));
    if (contains(aovs, "environment")) {
        if (config.environment.empty()) {
            inputs.environment = Environment::studio(axes, config.environment_turn);
        } else {
            LightImage image = read_light_image(config.environment);
            inputs.environment.emplace(image.width, image.height, std::move(image.rgb), axes,
                                       config.environment_turn);
        }
    }
    if (contains(aovs, "matcap")) {
        if (config.matcap.empty()) {
            inputs.matcap = Matcap::glazed();
        } else {
            LightImage image = read_light_image(config.matcap);
            inputs.matcap.emplace(image.width, image.height, std::move(image.rgb));
        }
    }
    inputs.relief = relief_of(config, model);
    return inputs;
}

Picture paint_shading(const std::string& aov, const ShadingInputs& inputs,
                      const RenderedFrame& frame, const RowRange& rows,
                      std::span<const HeightLabel> heights, int factor) {
    if (aov == "color") return paint_colors(*inputs.colors, frame, rows);
    if (aov == "environment") return paint_environment(*inputs.environment, frame, rows);
    if (aov == "matcap")
        return paint_rows(frame, rows, [&](const Vec3f& n, const Vec3f& e) {
            return inputs.matcap->color(n, e);
        });
    if (aov == "reflection")
        return paint_rows(frame, rows, [&](const Vec3f& n, const Vec3f& e) {
            const float grey = reflected_stripes(n, e);
            return Vec3f{grey, grey, grey};
        });
    return paint_relief(frame.buffer, frame.pixels, frame.view, rows, inputs.relief,
                        contour_width(frame.size.height), heights, factor);
}

void composite_over_environment(const Environment& environment, const PixelView& view, int x0,
                                int y0, Picture& picture) {
    parallel_blocks(static_cast<std::size_t>(picture.height), 8,
                    [&](std::size_t begin, std::size_t end) {
                        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                            for (int x = 0; x < picture.width; ++x) {
                                float* p = picture.pixel(x, y);
                                const float through = 1 - p[3];
                                if (!(through > 0)) continue;
                                const Vec3f light = environment.radiance(
                                    to_float(view.ray_direction(x0 + x + 0.5, y0 + y + 0.5)));
                                p[0] += through * light.x, p[1] += through * light.y,
                                    p[2] += through * light.z, p[3] += through;
                            }
                    });
}

}  // namespace slim
