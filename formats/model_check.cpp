#include "formats/model_check.h"

#include "formats/message.h"

#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr double kRounding = 1e-6;  // of bounds kept as floats

/// Whether a box lies in another one; one that is not there does.
bool is_part(const Bbox& box, const Bbox& whole) {
    if (box.lo == Bbox{}.lo && box.hi == Bbox{}.hi) return true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(whole.lo[axis] <= box.lo[axis] && box.lo[axis] <= box.hi[axis] &&
              box.hi[axis] <= whole.hi[axis]))
            return false;
    return true;
}

ModelFault check_header(const SurfelTree& tree) {
    const ModelHeader& h = tree.header();
    const auto fault = [](auto... parts) { return ModelFault{"header", 0, message(parts...)}; };
    if (h.degree < 0 || h.degree > kMaxDegree) return fault("degree ", h.degree, " is not 0 to 3");
    if (!is_finite(h.origin) || !is_finite(h.bounds.lo) || !is_finite(h.bounds.hi))
        return fault("origin or bounds are not finite");
    if (!(std::isfinite(h.diagonal) && h.diagonal >= 0)) return fault("diagonal ", h.diagonal);
    for (const Bbox& box : {h.drawn, h.drawn_loose})
        if (!is_part(box, h.bounds))
            return {"drawn", 0, "the box of what is drawn is no part of the points' box"};
    const std::size_t n = tree.n_nodes();
    const std::size_t stride = static_cast<std::size_t>(floats_per_surfel(h.degree));
    if (n == 0) return fault("a model has at least a root, found no node");
    if (tree.record_index().empty() && tree.records().size() != n * stride)
        return fault(n, " nodes need ", n * stride, " floats of records, found ",
                     tree.records().size());
    const std::size_t n_pages = (n + kSurfelsPerPage - 1) / kSurfelsPerPage;
    if (tree.page_origins().size() != n_pages)
        return fault(n, " nodes need ", n_pages, " pages, found ", tree.page_origins().size());
    return {};
}

/// Whether records of unequal size stand one after the other, as long as their nodes' degrees say.
ModelFault check_index(const SurfelTree& tree) {
    const RecordIndex& index = tree.record_index();
    if (index.empty()) return {};
    if (index.in_page.size() != tree.n_nodes() ||
        index.page_start.size() != tree.page_origins().size())
        return {"in_page", 0, message(index.in_page.size(), " records in ", index.page_start.size(),
                                      " pages, but there are ", tree.n_nodes(), " nodes")};
    std::uint64_t at = 0;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i) {
        const std::uint64_t start = index.page_start[i / kSurfelsPerPage] + index.in_page[i];
        if (start != at)
            return {"in_page", i, message("record begins at float ", start, ", expected ", at)};
        if (tree.node(i).degree > kMaxDegree)
            return {"nodes", i, message("degree ", int{tree.node(i).degree})};
        at += static_cast<std::uint64_t>(floats_per_surfel(tree.node(i).degree));
    }
    if (tree.records().size() != at)
        return {"in_page", 0, message("records need ", at, " floats, found ",
                                      tree.records().size())};
    return {};
}

ModelFault check_pages(const SurfelTree& tree) {
    for (std::size_t i = 0; i < tree.page_origins().size(); ++i)
        if (!is_finite(tree.page_origins()[i])) return {"pages", i, "origin is not finite"};
    return {};
}

ModelFault check_record(const SurfelTree& tree, std::size_t i) {
    const auto stride = static_cast<std::size_t>(floats_per_surfel(tree.record_degree(i)));
    const float* r = tree.record(i);
    for (std::size_t k = 0; k < stride; ++k)
        if (!std::isfinite(r[k])) return {"records", i, message("number ", k, " is not finite")};
    if (!(r[3] > 0)) return {"records", i, message("support radius ", r[3], " is not positive")};
    if (std::abs(r[4]) > 1 || std::abs(r[5]) > 1)
        return {"records", i, "the packed normal is outside [-1, 1]"};
    const TreeNode& node = tree.node(i);
    if (!(std::isfinite(node.bound_radius) && node.bound_radius >= r[3]))
        return {"nodes", i, message("bound radius ", node.bound_radius,
                                    " is less than support radius ", r[3])};
    return {};
}

/// What a node says of itself and where its children are.
ModelFault check_fields(const SurfelTree& tree, std::size_t i) {
    const TreeNode& node = tree.node(i);
    const auto fault = [&](auto... parts) { return ModelFault{"nodes", i, message(parts...)}; };
    if (node.degree > tree.header().degree)
        return fault("degree ", int{node.degree}, " is above the model's ", tree.header().degree);
    if (!std::isfinite(node.fit_error) || node.fit_error < 0)
        return fault("fit error ", node.fit_error);
    const PackedRims rims = node.rims();
    if (rims.any() && (!node.is_leaf() || (node.flags & kSharp)))
        return fault("rim ", int{rims.first}, " of a surfel that has none");
    if (rims.second != 0 && !rims.any())
        return fault("second rim ", int{rims.second}, " of a surfel without a first");
    if (node.n_children == 0) return {};
    if (node.first_child <= i)
        return fault("child ", node.first_child, " does not follow its parent");
    const std::uint64_t end = std::uint64_t{node.first_child} + node.n_children;
    if (end > tree.n_nodes())
        return fault("children up to ", end, ", but there are ", tree.n_nodes(), " nodes");
    return {};
}

ModelFault check_node(const SurfelTree& tree, std::size_t i, std::vector<bool>& has_parent) {
    if (ModelFault f = check_fields(tree, i); !f.chunk.empty()) return f;
    const TreeNode& node = tree.node(i);
    if (node.n_children == 0) return {};
    const std::uint64_t end = std::uint64_t{node.first_child} + node.n_children;
    for (std::size_t child = node.first_child; child < end; ++child) {
        if (has_parent[child])
            return {"nodes", i, message("child ", child, " has another parent too")};
        has_parent[child] = true;
    }
    return {};
}

/// A node's bound encloses those of its children: culling a subtree relies on it.
ModelFault check_bounds(const SurfelTree& tree, std::size_t i) {
    const TreeNode& node = tree.node(i);
    const double bound = static_cast<double>(node.bound_radius) * (1 + kRounding);
    for (std::size_t child = node.first_child; child < node.first_child + node.n_children; ++child)
        if (length(tree.center(child) - tree.center(i)) +
                static_cast<double>(tree.node(child).bound_radius) > bound)
            return {"nodes", i, message("bound radius ", node.bound_radius,
                                        " does not hold the ball of child ", child)};
    return {};
}

/// Whether entry i of the sharp nodes is one, in order, and its sheets are the next in the array.
ModelFault check_sharp(const SurfelTree& tree, std::size_t i, std::size_t& next_sheet) {
    const SharpEntry& e = tree.sharp()[i];
    const auto fault = [&](auto... parts) { return ModelFault{"sharp", i, message(parts...)}; };
    if (e.node >= tree.n_nodes() || !(tree.node(e.node).flags & kSharp))
        return fault("node ", e.node, " is not a sharp one");
    if (i > 0 && e.node <= tree.sharp()[i - 1].node)
        return fault("node ", e.node, " is out of order");
    if (e.n_extra < 1 || e.n_extra >= kMostSheets) return fault(int{e.n_extra}, " further sheets");
    if (e.outer > 1 || e.inner > 1) return fault("join ", int{e.outer}, ", ", int{e.inner});
    if (e.first_sheet != next_sheet)
        return fault("first sheet ", e.first_sheet, ", not ", next_sheet);
    next_sheet += e.n_extra;
    return {};
}

ModelFault check_all_sharp(const SurfelTree& tree) {
    std::size_t n_flagged = 0, n_sheets = 0;
    for (const TreeNode& node : tree.nodes()) n_flagged += (node.flags & kSharp) != 0;
    if (n_flagged != tree.sharp().size())
        return {"nodes", 0, message(n_flagged, " nodes are sharp, found ", tree.sharp().size())};
    for (std::size_t i = 0; i < tree.sharp().size(); ++i)
        if (ModelFault f = check_sharp(tree, i, n_sheets); !f.chunk.empty()) return f;
    const auto stride = static_cast<std::size_t>(floats_per_sheet(tree.header().degree));
    if (tree.sheets().size() != n_sheets * stride)
        return {"sheets", 0, message(n_sheets, " sheets need ", n_sheets * stride,
                                     " floats, found ", tree.sheets().size())};
    for (std::size_t k = 0; k < tree.sheets().size(); ++k)
        if (!std::isfinite(tree.sheets()[k]) || (k % stride < 2 && std::abs(tree.sheets()[k]) > 1))
            return {"sheets", k, message("number ", tree.sheets()[k], " is no part of a sheet")};
    return {};
}

}  // namespace

ModelFault check_sizes(const SurfelTree& tree) {
    if (ModelFault f = check_header(tree); !f.chunk.empty()) return f;
    const RecordIndex& index = tree.record_index();
    if (!index.empty() && (index.in_page.size() != tree.n_nodes() ||
                           index.page_start.size() != tree.page_origins().size()))
        return {"in_page", 0,
                message(index.in_page.size(), " records for ", tree.n_nodes(), " nodes")};
    const auto shortest = static_cast<std::uint64_t>(floats_per_surfel(0));
    for (std::size_t i = 0; i < index.in_page.size(); ++i)
        if (index.page_start[i / kSurfelsPerPage] + index.in_page[i] + shortest >
            tree.records().size())
            return {"in_page", i, "record lies outside the records"};
    return check_pages(tree);
}

ModelFault check_alone(const SurfelTree& tree, std::size_t i) {
    if (ModelFault f = check_fields(tree, i); !f.chunk.empty()) return f;
    if (!tree.record_index().empty()) {
        const auto length = static_cast<std::ptrdiff_t>(floats_per_surfel(tree.node(i).degree));
        if (tree.record(i) + length > tree.records().data() + tree.records().size())
            return {"in_page", i, "record ends outside the records"};
    }
    return check_record(tree, i);
}

ModelFault check_model(const SurfelTree& tree) {
    if (ModelFault f = check_header(tree); !f.chunk.empty()) return f;
    if (ModelFault f = check_index(tree); !f.chunk.empty()) return f;
    if (ModelFault f = check_pages(tree); !f.chunk.empty()) return f;
    std::vector<bool> has_parent(tree.n_nodes());
    std::uint64_t n_leaves = 0;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i) {
        // Parents come first, so a node's parent has been seen by now.
        if (i > 0 && !has_parent[i]) return {"nodes", i, "has no parent"};
        if (ModelFault f = check_node(tree, i, has_parent); !f.chunk.empty()) return f;
        if (ModelFault f = check_record(tree, i); !f.chunk.empty()) return f;
        n_leaves += tree.node(i).is_leaf() ? 1 : 0;
    }
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).n_children > 0)
            if (ModelFault f = check_bounds(tree, i); !f.chunk.empty()) return f;
    if (n_leaves != tree.header().n_leaves)
        return {"header", 0, message("says ", tree.header().n_leaves, " leaves, found ", n_leaves)};
    return check_all_sharp(tree);
}

}  // namespace slim
