#pragma once

#include "slim/model/fitted_surfel.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

/// What a fit leaves for the tree: surfels in its own order, and a JSON text about the fit as a whole
/// (the library does not look into it).
struct FitFile {
    std::string header_json;
    std::vector<FittedSurfel> surfels;
};

/// Throws as AtomicFile.
void write_fit(const std::string& path, std::span<const FittedSurfel> surfels,
               const std::string& header_json);

/// throws FormatError naming file, place and reason; IoError
FitFile read_fit(const std::string& path);

}  // namespace slim
