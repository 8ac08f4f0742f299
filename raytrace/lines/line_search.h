#pragma once

#include "raytrace/lines/creases.h"
#include "raytrace/lines/crest_look.h"
#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_scene.h"
#include "raytrace/lines/link.h"

#include <cstddef>
#include <span>
#include <vector>

namespace slim {

/// Rows that a band of a picture of that size holds above and below those that are searched, so
/// that it has all that the search looks at.
int line_margin(int picture_width, int picture_height);

/// The feature lines of a picture that is seen band by band, the same to the bit as of the whole at
/// once. What is kept of a band is its crossings with their links, 36 bytes each, of crest lines
/// 60, and some samples of the curvature (raytrace/lines/notes/0005, 0009).
///
/// Bands follow each other from the top down. Of each, rows [rows.begin, rows.end) of the planes
/// are searched, which begin where those of the band before ended; around them lie line_margin
/// rows, as far as the picture has them.
class LineSearch {
public:
    explicit LineSearch(std::span<const LineKind> kinds);

    /// Searches a band, the whole picture being one as well. cost O(pixels) per kind, parallel
    /// throws nothing; a channel that is missing, or a band that does not follow,
    ///        is a SLIM_CHECK failure
    void add(const LineScene& scene);

    /// The lines as extract_lines gives them, once all rows were added. What was found is gone
    /// then. Crest lines give way to creases, those found elsewhere (`creases`) included; each edge
    /// has one stroke (one_stroke.h).
    std::vector<FeatureLine> finish(std::span<const FeatureLine> creases = {});

private:
    /// What was found of one kind.
    struct Found {
        LineKind kind;
        std::vector<LinePoint> points;  ///< crossings, in the order of rows
        LineLinks links;
        std::size_t n_next = 0;  ///< of them those of the row after the last
                                 ///< band's, which the next one finds again
        std::vector<float> curvatures = {};  ///< sample of the view's, of suggestive contours
        std::vector<CrestLook> looks = {};   ///< of crest lines, of each crossing

        explicit Found(LineKind a_kind) : kind(a_kind) {}
        bool is_crest() const { return kind == LineKind::ridge || kind == LineKind::valley; }
        void append(const LineScene& scene, const CrossingField& field, const LineLinks& own,
                    bool is_last);
        void look_around(const CurvatureSamples& around);
        std::vector<FeatureLine> lines(int width, int height, double diagonal,
                                       const CurvatureSamples& around);
    };
    bool has_crests() const;
    bool looks_far() const;
    void leave_to_creases(std::span<const FeatureLine> elsewhere);

    std::vector<LineKind> kinds_;
    std::vector<Found> found_;           ///< of kinds other than creases, in their order
    std::vector<CreaseSearch> creases_;  ///< of creases, in theirs
    CurvatureSamples samples_;           ///< for crest and parabolic lines
    int width_ = 0, height_ = 0, next_row_ = 0;
    double diagonal_ = 1;
};

}  // namespace slim
