#pragma once

#include <string>

namespace slim {

/// What a fit is asked for, the same for `slim fit` and `slim build`.
struct FitOptions {
    std::string degree = "2";
    double t_mdl = 0.01;
    double lambda = 0;
    std::string radius_rule = "ladder";
    std::string weight = "gauss";
    std::string cover = "B";
    std::string sharp = "auto";

    template <class Visitor>
    void visit(Visitor&& field) {
        field.choice(
            "degree", degree,
            "polynomial degree of a surfel; auto: of each, the one that takes the fewest bytes "
            "for its error",
            {"1", "2", "3", "auto"});
        field("t_mdl", t_mdl,
              "T_MDL of eq. (3), fraction of the diagonal: larger is sparser and smoother", 1e-12,
              1e3);
        field("lambda", lambda,
              "noise variance of eq. (3), model units squared; 0: measured, of smoothed points "
              "what they had",
              0, 1e300);
        field.choice("radius_rule", radius_rule,
                     "how a surfel's radius is found; windows: the paper's, for comparison",
                     {"ladder", "windows"});
        field.choice("weight", weight,
                     "of the points in a fit; gauss: the paper's, polynomial: (1 - r^2)^4",
                     {"gauss", "polynomial"});
        field.choice("cover", cover,
                     "how far a leaf covers; A: the paper to the letter, B: G up to its radius, C: "
                     "a B-spline",
                     {"A", "B", "C"});
        field.choice(
            "sharp", sharp,
            "edges and corners get surfels of several sheets where that takes fewer bytes; "
            "auto: of a mesh of large faces, and if about 4 % of the places that are looked at, or "
            "more, lie at edges, as of CAD parts",
            {"auto", "on", "off"});
    }
};

}  // namespace slim
