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
    /// hash: of the sensors' positions; file: that was named, empty for those beside the inputs
    void add(std::size_t slice, const std::string& settings, const std::string& hash,
             const std::string& file);
    /// throws IncompleteError (exit 6) naming the slices and the options in which they differ
    void require_same(const std::string& work) const;

private:
    std::map<std::string, std::vector<std::size_t>> slices_;  ///< by their settings
    std::map<std::string, std::string> sensors_;              ///< what a line of them says
};

}  // namespace slim
