/* interrupt FILE COMMAND: runs the command, sends Ctrl-C to its console when FILE is there, and ends with its status.
 * The console is one of its own, since a process that hears Ctrl-C is any of the same console. */
#include <stdio.h>
#include <string.h>
#include <windows.h>

static BOOL WINAPI stay(DWORD event) { return event == CTRL_C_EVENT; }

int main(int argc, char **argv)
{
    STARTUPINFOA start;
    PROCESS_INFORMATION child;
    DWORD status = 1;
    memset(&start, 0, sizeof start);
    start.cb = sizeof start;
    FreeConsole();
    if (argc != 3 || !AllocConsole()) return 90;
    if (!CreateProcessA(NULL, argv[2], NULL, NULL, FALSE, 0, NULL, NULL, &start, &child)) return 91;
    SetConsoleCtrlHandler(stay, TRUE);
    for (int k = 0; k < 2400 && GetFileAttributesA(argv[1]) == INVALID_FILE_ATTRIBUTES; k++) Sleep(50);
    if (!GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0)) return 92;
    if (WaitForSingleObject(child.hProcess, 60000) != WAIT_OBJECT_0) {
        TerminateProcess(child.hProcess, 93);
        return 93;
    }
    return GetExitCodeProcess(child.hProcess, &status) ? (int)status : 94;
}
