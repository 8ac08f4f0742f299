#pragma once

#include "formats/atomic_file.h"
#include "formats/image_io.h"
#include "pipeline/render/render_files.h"
#include "raytrace/picture.h"
#include "raytrace/renderer.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// The files of a picture while they are written, images band by band from the top: all of them
/// appear, whole, or none.
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

    /// Values of the data file that halves do not hold (ExrWriter::n_clamped).
    std::uint64_t n_clamped() const { return exr_ ? exr_->n_clamped() : 0; }

    /// A file of its own beside the pictures, in a folder that is made if need be.
    void add_text(const NamedText& file);

    /// Nothing is added any more: everything is written, under temporary names still,
    /// which go with this object.
    void seal();
    /// Makes all of them visible; returns their names, those of images first.
    std::vector<std::filesystem::path> commit();

private:
    OutputPlan plan_;
    PictureSize whole_;
    PixelWindow window_;
    bool at_once_;
    ImageMatrices matrices_;
    std::vector<std::optional<PngWriter>> pngs_;
    std::optional<ExrWriter> exr_;
    std::vector<std::unique_ptr<AtomicFile>> texts_;
    bool sealed_ = false;
};

}  // namespace slim
