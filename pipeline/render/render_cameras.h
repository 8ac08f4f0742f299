#pragma once

#include "pipeline/render/render_view.h"

#include <string>
#include <vector>

namespace slim {

/// The keyframes of --path, "iso zoom 2" each; a single empty one without it.
std::vector<std::string> keyframes_of(const RenderConfig& config);

/// The cameras of the run, as named or in numbers: --camera, or those of --path's keyframes.
std::vector<std::string> cameras_of(const RenderConfig& config);

/// How many pictures: of --turntable or --frames, 1 without either. Throws ConfigError where they,
/// --path and --frame do not fit together.
int n_frames(const RenderConfig& config);

/// The cameras of the pictures of a turntable or path; of one picture make_camera's.
class FilmCameras {
public:
    /// Throws ConfigError. cost: make_camera's for each keyframe
    FilmCameras(const RenderConfig& config, const ModelHeader& model, const PictureSize& size,
                const LegendRoom& room);

    /// Of picture `frame`, from 0. cost O(keyframes)
    Camera at(int frame) const;

private:
    int frames_, turntable_;    ///< of a path and of a turntable; 0: none
    Vec3d center_, up_;         ///< what a turntable turns about
    std::vector<Camera> keys_;  ///< of a path; the only one without
};

}  // namespace slim
