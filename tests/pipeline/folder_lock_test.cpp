#include "pipeline/folder_lock.h"

#include "slim/base/error.h"
#include "tests/formats/format_support.h"

#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <unistd.h>

namespace slim::test {
namespace {

using Hold = FolderLock::Hold;

/// As another process would hold the folder, which locks of one process on two descriptors are
/// like.
class Other {
public:
    Other(const std::string& folder, int how)
        : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY)),
          got_(flock(descriptor_, how | LOCK_NB) == 0) {}
    ~Other() { close(descriptor_); }
    Other(const Other&) = delete;
    Other& operator=(const Other&) = delete;
    bool got() const { return got_; }

private:
    int descriptor_;
    bool got_;
};

ExitCode refusal(const std::string& folder, Hold hold) {
    try {
        const FolderLock lock(folder, hold);
    } catch (const Error& error) {
        return error.code();
    }
    return ExitCode::ok;
}

TEST(FolderLock, AloneKeepsAllOthersOutSharedOnlyThoseAlone) {
    const TempFolder folder;
    const std::string work = folder.file("");
    {
        const FolderLock lock(work);
        EXPECT_FALSE(Other(work, LOCK_SH).got());
    }
    const FolderLock lock(work, Hold::shared);
    EXPECT_TRUE(Other(work, LOCK_SH).got());
    EXPECT_FALSE(Other(work, LOCK_EX).got());
}

TEST(FolderLock, IsRefusedWhereAnotherIsAtWork) {
    const TempFolder folder;
    const std::string work = folder.file("");
    {
        const Other alone(work, LOCK_EX);
        EXPECT_EQ(refusal(work, Hold::alone), ExitCode::temporary);
        EXPECT_EQ(refusal(work, Hold::shared), ExitCode::temporary);
    }
    const Other shared(work, LOCK_SH);
    EXPECT_EQ(refusal(work, Hold::alone), ExitCode::temporary);
    EXPECT_EQ(refusal(work, Hold::shared), ExitCode::ok);
}

TEST(FolderLock, StagesOfABuildAreWithinItsLock) {
    const TempFolder folder;
    const std::string work = folder.file("");
    const FolderLock build(work);
    EXPECT_EQ(refusal(work, Hold::shared), ExitCode::ok);
    EXPECT_EQ(refusal(work, Hold::alone), ExitCode::ok);
    EXPECT_FALSE(Other(work, LOCK_SH).got()) << "the inner lock must not end the outer one";
}

TEST(FolderLock, OnlyTheOneThatBeginsMakesTheFolder) {
    const TempFolder folder;
    { const FolderLock lock(folder.file("shared"), Hold::shared); }
    { const FolderLock lock(folder.file("alone")); }
    EXPECT_FALSE(std::filesystem::exists(folder.file("shared")));
    EXPECT_TRUE(std::filesystem::exists(folder.file("alone")));
}

}  // namespace
}  // namespace slim::test
