#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace slim {

// The keys of a job's tables that are the job's own, and those of the verbs that it fills in
// itself.

inline constexpr int kJobSchema = 1;  ///< schema_version that this program reads

inline const std::vector<std::string> kJobTables = {"input", "fit",    "render", "light",
                                                    "view",  "output", "measure"};

struct InputTable {
    std::vector<std::string> files;
    template <class V>
    void visit(V&& field) {
        field.path("files", files, "point clouds");
    }
};

struct OutputTable {
    std::string dir;
    std::string title;
    std::vector<std::string> aovs = {"shaded"};
    bool html = true;
    template <class V>
    void visit(V&& field) {
        field.path("dir", dir, "folder for everything that is written");
        field("title", title, "heading of the page");
        field("aovs", aovs, "pictures of every view that names none");
        field("html", html, "write DIR/index.html");
    }
};

/// The keys of a view that are the job's own; the others are options of slim-render.
struct ViewTable {
    std::string name;
    std::vector<std::string> aovs;
    int shares = 0;
    template <class V>
    void visit(V&& field) {
        field("name", name, "begins the names of the view's pictures");
        field("aovs", aovs, "pictures of this view");
        field("shares", shares, "tasks that plans divide it among (0: by its pixels)", 0, 9999);
    }
};

/// The keys of [render] that are the job's own.
struct AllViewsTable {
    int shares = 0;
    template <class V>
    void visit(V&& field) {
        field("shares", shares, "of every view that does not say it itself", 0, 9999);
    }
};

inline const std::set<std::string> kOwnedOfScan = {"output"};
inline const std::set<std::string> kOwnedOfFit = {"inputs", "output"};
inline const std::set<std::string> kOwnedOfView = {"model", "output", "job",
                                                   "aov",   "share",  "join"};
/// Those, and what is one for each view.
inline const std::set<std::string> kOwnedOfRender = {"model", "output", "job", "aov",
                                                     "share", "join",   "name"};

inline std::set<std::string> owned_of_measure(std::size_t n_clouds) {
    std::set<std::string> owned = {"model", "cloud", "output",
                                   "offset"};  // of shapes, and a job measures models
    if (n_clouds > 1) owned.insert("per_point");  // one file for one cloud
    return owned;
}

}  // namespace slim
