#pragma once

#include "formats/image_io.h"
#include "pipeline/render_files.h"
#include "raytrace/picture.h"
#include "raytrace/renderer.h"

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace slim {

/// The pictures of a run while they are written, band by band from the top; whole files or none.
class PictureFiles {
public:
    /// window: what of the whole is written. at_once: as one band.
    PictureFiles(const OutputPlan& plan, const PictureSize& whole, const PixelWindow& window,
                 bool at_once, ImageMatrices matrices)
        : plan_(plan),
          whole_(whole),
          window_(window),
          at_once_(at_once),
          matrices_(std::move(matrices)),
          pngs_(plan.pngs.size()) {}

    /// The next band of picture k of the plan. Without `opaque` alpha is written too, unless all
    /// comes at once and is opaque. The first band's metadata count.
    void add_png(std::size_t k, const Picture& band, bool opaque, const ImageMetadata& metadata);
    /// The next band of the data file.
    void add_exr(int n_rows, std::span<const ExrChannel> channels, const ImageMetadata& metadata);

    /// Makes all of them visible; returns their names.
    std::vector<std::filesystem::path> commit();

private:
    const OutputPlan& plan_;
    PictureSize whole_;
    PixelWindow window_;
    bool at_once_;
    ImageMatrices matrices_;
    std::vector<std::optional<PngWriter>> pngs_;
    std::optional<ExrWriter> exr_;
};

}  // namespace slim
