#pragma once

#include "formats/model_file.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_config.h"
#include "raytrace/camera.h"
#include "raytrace/trace/look.h"
#include "raytrace/trace/trace_scene.h"
#include "slim/color/color_blend.h"
#include "slim/model/surfel_tree.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// A model's header, its bounds and hull those of what is drawn of it.
ModelHeader drawn_header(const SurfelTree& tree, bool loose,
                         std::vector<std::uint32_t>* visited = nullptr);

/// Channels that shading and openness take beside those of the AOVs.
Channels light_channels(const RenderConfig& config, const std::vector<std::string>& aovs);

/// The models of a traced picture, ready for rays.
class TracedModels {
public:
    /// `first` must outlive it. Opens config.add (FormatError, IoError, DataError naming the file).
    TracedModels(const RenderConfig& config, const SurfelTree& first);

    const TraceScene& scene() const { return *scene_; }
    /// The first model's header, its bounds those of what is drawn of all and, of several, its
    /// diagonal that of these.
    const ModelHeader& header() const { return header_; }
    /// Each model's own.
    std::vector<const ModelHeader*> headers() const;
    /// The models themselves, with their places in the first one's frame.
    std::span<const ScenePart> parts() const { return scene_->parts(); }
    double build_ms() const { return build_ms_; }
    /// Where a ground lies that the models stand on: a surfel of a thousand has its centre lower.
    /// (The outlines of single surfels reach lower still; under those a model would hover.) Of one
    /// with sharp surfels, whose outlines are its edges, nothing is lower.
    double lowest() const { return lowest_; }

private:
    double lowest_along(const Vec3d& up) const;

    std::vector<std::unique_ptr<ModelFile>> files_;
    std::vector<std::unique_ptr<SurfelTree>> trees_;
    std::unique_ptr<TraceScene> scene_;
    ModelHeader header_;
    double build_ms_ = 0;
    double lowest_ = 0;  ///< with a ground only
};

/// Where the ground cuts the up axis, world frame.
double ground_level(const RenderConfig& config, const TracedModels& models);

/// What shades a frame: lights and materials, and the rays that the picture is cast with, if it is.
struct FrameLight {
    const RenderConfig& config;
    const ModelHeader& header;
    const Camera& camera;
    const TracedModels* traced = nullptr;
    const ColorBlend* colors = nullptr;  ///< of the scan, if the material has them
};

/// Fills frame.open, the ambient openness of every hit, and if a picture shows it
/// frame.ground_open.
void find_openness(const FrameLight& light, RenderedFrame& frame);

/// Whether there is a ground and every light is below it.
bool lights_are_below_ground(const FrameLight& light, const ShadeView& view);

/// Fills frame.shaded, at the picture's size: one pixel for `factor` x `factor` of the frame; keeps
/// its memory if it can.
void shade_frame(const FrameLight& light, int factor, RenderedFrame& frame);

}  // namespace slim
