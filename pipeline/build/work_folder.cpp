#include "pipeline/build/work_folder.h"

#include "pipeline/build/plan_file.h"
#include "pipeline/folder_lock.h"
#include "pipeline/json_text.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "made_by_slim_build";
constexpr std::string_view kMarkText =
    "slim build put this file here: the folder is its own, and goes when the model is done.\n";
constexpr auto kWorkFiles = std::to_array<std::string_view>(
    {"plan.json", "slice.done.json", "coarse.fit", "coarse.fit.done.json", "signs.slice",
     "signs.slice.done.json", "tree.done.json"});
constexpr auto kSliceFiles = std::to_array<std::string_view>(
    {"points.slice", "points.slice.done.json", "oriented.slice", "oriented.slice.done.json",
     "surfels.fit", "surfels.fit.done.json"});

/// Whether it is one of the files, or half of one (temporary_suffix()).
template <class Names>
bool is_one_of(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name.substr(0, name.find(".tmp."))) != names.end();
}

bool is_slice_folder(const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    constexpr std::string_view kBegin = "slice_";
    return name.starts_with(kBegin) && name.size() >= kBegin.size() + 4 &&
           name.find_first_not_of("0123456789", kBegin.size()) == std::string::npos &&
           entry.symlink_status().type() == fs::file_type::directory;
}

std::vector<fs::directory_entry> entries_of(const fs::path& folder) {
    std::vector<fs::directory_entry> out;
    std::error_code none;
    for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none))
        out.push_back(*at);
    return out;
}

bool is_marked(const fs::path& work) {
    std::error_code none;
    return fs::is_regular_file(fs::symlink_status(work / kMark, none));
}

/// Under its name at once: a kill leaves no half of it that would seem someone's.
void mark(const std::string& work) {
    const std::string path = work + "/" + kMark;
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) {
        const bool full = errno == ENOSPC || errno == EDQUOT;
        throw IoError({.file = work,
                       .problem = fmt::format("cannot write into this folder: {}",
                                              std::strerror(errno))},
                      full ? ExitCode::resource : ExitCode::usage);
    }
    // what it says is for people: an empty one does as well
    if (::write(file, kMarkText.data(), kMarkText.size()) < 0) errno = 0;
    ::close(file);
}

/// Others call files plan.json, too.
bool holds_a_plan(const fs::path& work) {
    std::ifstream file(plan_path(work));
    const auto plan = json_or_discarded(file);
    return plan.is_object() && plan.contains("version") && plan.contains("slices") &&
           plan.contains("coordinate_quantum");
}

bool is_link(const std::string& path) {
    std::error_code none;
    return fs::is_symlink(fs::symlink_status(path, none));
}

void remove_mark(const fs::path& work) { ::unlink((work / kMark).c_str()); }

std::string name_aside(const std::string& work) { return work + ".done"; }

/// Returns whether nothing else is there, but for the mark. Another process may be removing them,
/// too.
template <class Names>
bool remove_named(const fs::path& folder, const Names& names) {
    bool all = true;
    for (const fs::directory_entry& entry : entries_of(folder)) {
        const std::string name = entry.path().filename().string();
        const bool goes = is_one_of(names, name) &&
                          (::unlink(entry.path().c_str()) == 0 || errno == ENOENT);
        all &= goes || name == kMark;
    }
    return all;
}

}  // namespace

WorkFolder claim_own_work(const std::string& path) {
    WorkFolder out{path};
    out.had_plan = fs::exists(plan_path(path));
    out.is_own = is_marked(path);
    out.stays = is_link(path);
    if (out.is_own) return out;
    if (entries_of(path).empty()) {
        mark(path);
        out.is_own = true;
        return out;
    }
    if (holds_a_plan(path)) return out;
    throw ConfigError(
        {.file = path,
         .problem = "a build without --work has its intermediate files there and removes them, but "
                    "this folder holds files that no build made: name another one with --work DIR, "
                    "which is kept, or remove this one"});
}

void unmark_work(const fs::path& work) {
    if (!is_marked(work)) return;
    const FolderLock lock(work.string());
    remove_mark(work);
}

bool remove_slice_files(const fs::path& folder) {
    const bool all = remove_named(folder, kSliceFiles);
    return all && ::rmdir(folder.c_str()) == 0;
}

bool remove_own_work(const WorkFolder& work) {
    // The system takes a large file's pages back one by one.
    const std::vector<fs::directory_entry> entries = entries_of(work.path);
    parallel_blocks(entries.size(), 1, [&](std::size_t i, std::size_t) {
        if (is_slice_folder(entries[i])) remove_slice_files(entries[i].path());
    });
    const bool all = remove_named(work.path, kWorkFiles);
    remove_mark(work.path);  // last: a kill before leaves a folder that is known as a build's
    if (all && !work.stays) ::rmdir(work.path.c_str());
    return all;
}

bool put_aside(const WorkFolder& work) {
    const auto is_known = [](const fs::directory_entry& entry) {
        const std::string name = entry.path().filename().string();
        return name == kMark || is_one_of(kWorkFiles, name) || is_slice_folder(entry);
    };
    const auto entries = entries_of(work.path);
    const bool is_all_ours = std::all_of(entries.begin(), entries.end(), is_known);
    const std::string aside = name_aside(work.path);
    std::error_code error;
    if (is_all_ours && !work.stays && !fs::exists(fs::symlink_status(aside, error))) {
        fs::rename(work.path, aside, error);
        if (!error) return true;
    }
    return remove_own_work(work);
}

void bring_back(const WorkFolder& work) {
    const std::string aside = name_aside(work.path);
    std::error_code error;
    if (is_link(aside) || !is_marked(aside) || fs::exists(fs::symlink_status(work.path, error)))
        return;
    fs::rename(aside, work.path, error);
}

void remove_put_aside(const std::string& work) {
    const std::string aside = name_aside(work);
    if (!is_link(aside) && is_marked(aside)) remove_own_work({aside, true});
}

}  // namespace slim
