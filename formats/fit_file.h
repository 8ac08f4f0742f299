#pragma once

#include "slim/model/fitted_surfel.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What a fit leaves for the tree: surfels in its own order, and a JSON text about the fit as a whole
/// (the library does not look into it).
struct FitFile {
    std::string header_json;
    std::vector<FittedSurfel> surfels;
    std::vector<std::uint64_t> dropped;  ///< ids of points that belong to no surfel, for the fits after this one
};

/// Throws as AtomicFile.
void write_fit(const std::string& path, std::span<const FittedSurfel> surfels,
               const std::string& header_json, std::span<const std::uint64_t> dropped = {});

/// The surfels that are wanted (all if that is empty); takes no memory but theirs.
/// throws FormatError naming file, place and reason; IoError
FitFile read_fit(const std::string& path,
                 const std::function<bool(const FittedSurfel&)>& is_wanted = {});

}  // namespace slim
