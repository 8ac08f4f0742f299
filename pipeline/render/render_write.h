#pragma once

#include "pipeline/render/render_job.h"
#include "pipeline/render/render_output.h"

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// Finishes a band of every drawn AOV (background, lines, legend, scale bar) and adds it to its
/// file, and the band's data to the data file. Returns what of legend and scale bar had no room, in
/// words, or nothing.
std::string write_band(const RenderJob& job, const Frames& frames, const PicturePart& part,
                       const ImageMetadata& metadata, PictureFiles& files);

/// Whether every pixel of an AOV's picture hides what is behind it.
bool has_background(const RenderConfig& config, const std::string& aov);

/// Legends and keys as SVG, beside the pictures.
std::vector<NamedText> legend_files(const RenderJob& job);

}  // namespace slim
