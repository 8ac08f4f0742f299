#pragma once

#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_job.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// What a run came to.
struct RenderOutcome {
    RenderStats stats;
    double frame_ms = 0;  ///< of all bands
    int factor = 1;
    int frames = 0;
    bool whole_at_once = false;    ///< whether the picture that this is (a part of) fits one band
    /// with more than one sample (--antialias), of all pictures
    std::uint64_t smoothed_pixels = 0;
    std::uint64_t truth_unknown = 0;
    std::uint64_t plane_bytes = 0;  ///< that a pixel of the frame takes in its planes
    std::uint64_t clamped = 0;     ///< values of EXRs that halves do not hold
    std::uint64_t light_rays = 0;  ///< all but the primary ones
    nlohmann::json lines;
    std::vector<std::filesystem::path> files;
};

/// Draws and writes all pictures of the run; legends are those of the whole film. All files of a
/// picture, lines and legends among them, appear together once it is whole; those of a film stay if
/// a later picture fails.
/// Throws NumericalError where a whole picture shows nothing.
RenderOutcome draw_film(RenderJob& job, const FilmCameras& cameras,
                        const std::string& model_identity, StageContext& context);

}  // namespace slim
