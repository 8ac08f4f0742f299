#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace slim {

/// The options that the normals of a job's slices were made with, by what their manifests say.
class NormalsSettings {
public:
    /// settings: lines "key = value" (StageContext::config); empty in manifests that say none
    void add(std::size_t slice, const std::string& settings);
    /// throws IncompleteError (exit 6) naming the slices and the options in which they differ
    void require_same(const std::string& work) const;

private:
    std::map<std::string, std::vector<std::size_t>> slices_;  ///< by their settings
};

}  // namespace slim
