#pragma once

#include "pipeline/contains.h"
#include "pipeline/render/model_reads.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_files.h"
#include "pipeline/render/render_lines.h"
#include "pipeline/render/render_look.h"
#include "pipeline/render/render_parts.h"
#include "pipeline/render/render_shadings.h"
#include "pipeline/render/render_share.h"
#include "pipeline/render/render_trace.h"
#include "pipeline/render/render_view.h"
#include "raytrace/renderer.h"
#include "slim/blend/leaf_hessians.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// All that is fixed before the first pixel.
struct RenderJob {
    const RenderConfig& config;
    const SurfelTree& tree;
    std::vector<std::string> aovs;
    OutputPlan plan;
    PictureSize size;
    Camera camera;
    std::vector<LineKind> lines;  ///< in the order of drawing
    PixelWindow window;           ///< what of the picture is wanted
    ShadingInputs shadings;
    int n_frames = 1;
    ModelHeader drawn;  ///< the model's; its bounds are those of what is drawn, of all models
    const TracedModels* traced = nullptr;  ///< with --mode raytrace
    ModelReads* reads = nullptr;           ///< is told of every node before it is drawn
    RenderShare share = {};                ///< of the film or picture
    ContourLevels contours = {};           ///< of a relief, among the heights seen
    bool tints = false;  ///< whether the shaded picture has the scan's colours
    std::map<std::string, AovLook> looks = {};
    /// those of the picture, in the order of drawing, once they are found
    std::optional<std::vector<FeatureLine>> found_lines = {};
    std::vector<std::vector<SharpEdge>> edges = {};  ///< of each model, if creases are drawn
    /// Of the tree, from picture to picture: of those that pictures ask for.
    std::shared_ptr<LeafHessians> hessians = std::make_shared<LeafHessians>(tree);

    /// Its bounds are those of what is drawn; of several models these and its diagonal are those of
    /// all.
    const ModelHeader& header() const { return drawn; }
    /// Those of each model, in the order in which pixels number them.
    std::vector<const ModelHeader*> models() const {
        return traced ? traced->headers() : std::vector<const ModelHeader*>{&tree.header()};
    }
    std::vector<LineModel> line_models() const {
        std::vector<LineModel> out;
        for (const ModelHeader* model : models()) out.push_back({model});
        for (std::size_t m = 0; m < edges.size(); ++m) out[m].edges = edges[m];
        return out;
    }
    FrameLight light() const {
        return {config, header(), camera, traced, tints ? &*shadings.colors : nullptr};
    }
    Channels channels(const std::vector<std::string>& of) const {
        return channels_of(of, config.light_maps) | light_channels(config, of);
    }
    /// What a frame must hold for lines that are to be found in it.
    Channels for_lines() const {
        return found_lines ? Channels{0} : line_channels(lines, tree.header().degree);
    }
    bool finds_lines() const { return !lines.empty() && !found_lines; }
    /// The lines found, to be shown in a part of the picture.
    DrawnLines drawn_lines(const PixelWindow& part) const {
        return {found_lines ? std::span<const FeatureLine>(*found_lines)
                            : std::span<const FeatureLine>(),
                lines, size, part};
    }
    /// Whether pixels at edges of the pictures have more samples than others (smooth_edges).
    bool antialiases() const { return slim::antialiases(config); }
    bool wants(const char* aov) const {
        return contains(aovs, aov);
    }
};

/// The frames of a run: `fine` for pictures that are averaged (twice the size with supersample 2),
/// `plain` for all else. Without supersampling both are the same one.
struct Frames {
    RenderedFrame plain, fine;
    std::vector<FeatureLine> lines;  ///< of a whole picture, unless they were found before
    bool has_fine = false;
    RenderStats stats;
    double median_ms = 0;
    std::uint64_t truth_unknown = 0;  ///< hits without a distance to the truth, of the margin, too
    std::uint64_t covered = 0;  ///< of the part that is wanted, not of its margin
    /// Pictures whose edges are antialiased, but for `shaded`, which the plain frame holds.
    std::map<std::string, Picture> smoothed = {};
    std::uint64_t n_smoothed = 0;  ///< pixels of the part that is wanted with more than one sample

    const RenderedFrame& for_aov(const std::string& aov) const {
        return has_fine && is_filterable(aov) ? fine : plain;
    }
};

/// What the plain frame is for: data files take all, pictures only what is never averaged.
std::vector<std::string> plain_aovs(const RenderJob& job);

/// What is averaged where there are several samples: pictures, and the colour in a data file.
std::vector<std::string> averaged_aovs(const RenderJob& job);

/// What the fine frame is for: these, if the whole picture has several samples.
std::vector<std::string> fine_aovs(const RenderJob& job);

/// A window of the picture in pixels of a frame `factor` times as large.
inline PixelWindow times(const PixelWindow& w, int factor) {
    return {w.x * factor, w.y * factor, w.width * factor, w.height * factor};
}

}  // namespace slim
