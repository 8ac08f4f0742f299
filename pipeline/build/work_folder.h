#pragma once

#include <filesystem>
#include <string>

namespace slim {

/// The folder of a build's intermediate files: one that --work names, which is kept, or
/// `<output>.work`. The latter is the build's own, and goes with its end, if it bears a mark: a
/// file that a build puts into a folder that it made or found empty, as a kill between making and
/// marking leaves it. One without, which `slim slice` filled, is used and kept.
struct WorkFolder {
    std::string path;
    bool is_own = false;
    bool stays = false;  ///< of an own one: it is a link: its files go alone
    bool had_plan = false;  ///< before this build
};

/// `<output>.work`, locked by the caller, for a build that was given no other.
/// throws ConfigError if there are files in it that neither a build nor `slim slice` put there
WorkFolder claim_own_work(const std::string& path);

/// A folder that someone names is theirs, also if a killed build left it.
/// throws Error, exit code `temporary`, if a build of another process is at work in it
void unmark_work(const std::filesystem::path& work);

/// Removes the files that builds write into an own folder, and itself if nothing else is in it.
/// Files of others stay. Returns whether all went.
bool remove_own_work(const WorkFolder& work);
/// The same for one slice's folder.
bool remove_slice_files(const std::filesystem::path& folder);

/// Moves an own folder to `<output>.work.done`, or removes it where that cannot be: nothing in it
/// is needed once the build's record is there. Call before its commit: a build may be killed
/// between that and the end of the removal, and the next one, which may find itself up to date,
/// knows by the name that the folder is nobody's.
bool put_aside(const WorkFolder& work);
/// Undoes put_aside(), where it moved the folder, after a commit that failed.
void bring_back(const WorkFolder& work);
/// Removes what put_aside() made of that folder, now or before a kill.
void remove_put_aside(const std::string& work);

}  // namespace slim
