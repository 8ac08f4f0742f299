#pragma once

#include <string>

namespace slim {

/// Keeps a work folder to one process at a time, or to those that only add files of their own to
/// it: an advisory lock on the folder itself, which ends with the process however that ends (kill
/// -9 too) and leaves no file behind. The folder may be removed while locked. On a file system
/// without locks it does nothing, and within a lock of this process on the same folder (a build's
/// about its stages) neither.
class FolderLock {
public:
    enum class Hold {
        alone,   ///< makes the folder if it is missing (make_folders)
        shared,  ///< beside other shared ones: tasks that do a slice each
    };
    /// throws Error with exit code `temporary` (75) at once if another process holds it; IoError
    /// (2) if the folder cannot be made
    explicit FolderLock(const std::string& folder, Hold hold = Hold::alone);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    /// -1 if it is missing and not to be made.
    int open_folder(const std::string& folder, Hold hold);

    int descriptor_ = -1;  ///< -1: nothing is held
};

}  // namespace slim
