#include "pipeline/render/render_reference.h"

#include "pipeline/contains.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_contours.h"
#include "pipeline/render/render_frames.h"
#include "pipeline/render/render_maps.h"
#include "slim/tree/curvature_noise.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace slim {
namespace {

/// The longer side of the frame that ranges are taken from.
constexpr int kReferenceSide = 1000;

/// The size at which ranges, legends and contour spacing of a picture are decided: at most 1000
/// pixels on the longer side.
PictureSize reference_size(const PictureSize& size) {
    const int longer = std::max(size.width, size.height);
    if (longer <= kReferenceSide) return size;
    const auto scaled = [&](int side) {
        return std::max(1, static_cast<int>(std::int64_t{side} * kReferenceSide / longer));
    };
    return {scaled(size.width), scaled(size.height)};
}

/// A pixel of the picture in pixels of that frame.
double reference_scale(const PictureSize& size) {
    return static_cast<double>(reference_size(size).width) / size.width;
}

/// What reference pictures are drawn for: ranges, legends and contour spacing; none if it is empty.
std::vector<std::string> reference_aovs(const RenderJob& job) {
    std::vector<std::string> aovs;
    for (const std::string& aov : job.plan.drawn)
        if (needs_reference(job.config, aov)) aovs.push_back(aov);
    // A data file shows the contours of a relief that is not its preview.
    if (job.wants("hillshade") && job.config.contours != "none" && !contains(aovs, "hillshade"))
        aovs.push_back("hillshade");
    return aovs;
}

/// A camera of same_range.
Camera camera_of_range(const RenderJob& job, const std::string& name) {
    RenderConfig config = job.config;
    config.camera = name;
    return make_camera(config, job.header(), job.size,
                       legend_room(config, job.plan.framed(), job.size));
}

/// What the fit of a model makes of flat faces. Its nodes are checked first: a view may meet few.
double noise_of(const SurfelTree& tree, ModelReads* reads) {
    const SampledNodes sample = nodes_for_curvature_noise(tree);
    if (reads) reads->meet(sample.nodes);
    return curvature_noise(tree, sample);
}

/// Of several models what is known worst of one, where the others' flat faces are too.
MapScale scale_of(const RenderJob& job, const std::vector<std::string>& aovs) {
    MapScale scale{job.header().diagonal, 0};
    if (std::none_of(aovs.begin(), aovs.end(), is_curvature)) return scale;
    if (!job.traced) scale.curvature_noise = noise_of(job.tree, job.reads);
    else  // checked as a whole
        for (const ScenePart& part : job.traced->parts())
            scale.curvature_noise = std::max(scale.curvature_noise, noise_of(*part.tree, nullptr));
    return scale;
}

/// For each map the union of its ranges from all cameras of same_range.
std::map<std::string, ValueRange> ranges_of_cameras(RenderJob& job,
                                                    const std::vector<std::string>& aovs,
                                                    const MapScale& scale) {
    std::map<std::string, ValueRange> ranges;
    if (aovs.empty()) return ranges;
    const Camera own = job.camera;
    const PictureSize size = reference_size(job.size);
    for (const std::string& name : job.config.same_range) {
        RenderConfig config = job.config;
        config.camera = name;
        job.camera = camera_of_range(job, name);
        RenderedFrame frame;
        draw_buffer(job, size, {0, 0, size.width, size.height},
                    config.lod * reference_scale(job.size), channels_of(aovs, false), frame);
        if (contains(aovs, "truth_distance"))
            frame.truth_distance = truth_distances(config, job.tree.header().origin, frame.buffer);
        for (const std::string& aov : aovs) {
            if (!map_spec(aov)) continue;
            const ValueRange range = range_of(config, aov, frame, scale);
            const auto [at, is_new] = ranges.emplace(aov, range);
            if (!is_new)
                at->second.lo = std::min(at->second.lo, range.lo),
                at->second.hi = std::max(at->second.hi, range.hi);
        }
    }
    job.camera = own;
    return ranges;
}

}  // namespace

void choose_looks(RenderJob& job, Reporter& reporter) {
    RenderedFrame reference;
    const std::vector<std::string> aovs = reference_aovs(job);
    const auto has = [&](const char* aov) { return contains(aovs, aov); };
    if (!aovs.empty()) {
        const PictureSize size = reference_size(job.size);
        draw_buffer(job, size, {0, 0, size.width, size.height},
                    job.config.lod * reference_scale(job.size), channels_of(aovs, false),
                    reference);
        if (has("truth_distance"))
            reference.truth_distance =
                truth_distances(job.config, job.tree.header().origin, reference.buffer);
        if (has("hillshade") && job.config.contours != "none")
            choose_contours(job, reference, reporter);
    }
    const MapScale scale = scale_of(job, aovs);
    const auto wider = ranges_of_cameras(job, aovs, scale);
    for (const std::string& aov : job.plan.drawn) {
        AovLook& look = job.looks[aov];
        look = look_of(job.config, aov, reference, scale, job.contours,
                       wider.contains(aov) ? &wider.at(aov) : nullptr);
        if (aov == "hillshade") look.heights = contour_heights(job, look, reference);
    }
}

}  // namespace slim
