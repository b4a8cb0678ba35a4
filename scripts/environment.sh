#!/bin/sh
# Makes the environment in .venv ready, and says what it does. Nothing happens where it is ready already.
#
#   scripts/environment.sh core    what the library needs to fly, and to draw diagrams
#   scripts/environment.sh dev     that, and what its tests, checks and documentation need
#   scripts/environment.sh list    every Python found that can make an environment, newest first: version and path
#
# PYTHON names the Python to use: a name, or a path. Without it the newest one found is used. An environment that is
# there is kept if it is of that Python's version, or if PYTHON is empty and the environment works.
set -eu
cd "$(dirname "$0")/.."

NAMES="python3.14 python3.13 python3.12 python3.11 python3"
VENV=.venv

fail() {
    echo "error: $*" >&2
    exit 1
}

# The version of a Python as "3.13". Fails where it does not run, or lacks the modules that make an environment
# (Debian keeps ensurepip in a package of its own).
version_of() {
    "$1" -c 'import ensurepip, sys, venv; print("%d.%d" % sys.version_info[:2])' 2>/dev/null
}

is_recent() {
    case $1 in
    3.[0-9] | 3.10 | [12].*) return 1 ;;
    esac
}

# Drake has wheels for these. A newer one is used only where PYTHON asks for it.
is_supported() {
    case $1 in
    3.11 | 3.12 | 3.13 | 3.14) ;;
    *) return 1 ;;
    esac
}

# A name may stand in several folders of PATH, and the first may be one that does not run, as pyenv's are for versions
# that are not chosen. So each of them is tried.
list_pythons() {
    for name in $NAMES; do
        found=$(
            IFS=:
            for folder in $PATH; do
                # An environment that is active must not be made anew by its own Python.
                [ "$folder" != "$PWD/$VENV/bin" ] || continue
                [ -x "$folder/$name" ] && [ ! -d "$folder/$name" ] || continue
                version=$(version_of "$folder/$name") || continue
                is_supported "$version" || continue
                echo "$version $folder/$name"
                break
            done
        )
        case $found in
        "") ;;
        *) echo "$found" ;;
        esac
    done | sort -s -t. -k1,1nr -k2,2nr | awk '!seen[$1]++'
}

chosen_python() {
    if [ -n "${PYTHON:-}" ]; then
        command -v "$PYTHON" >/dev/null || fail "PYTHON=$PYTHON: there is no such program"
        version=$(version_of "$PYTHON") ||
            fail "PYTHON=$PYTHON: does not run, or lacks the modules venv and ensurepip:" \
                "$("$PYTHON" -c 'import ensurepip, venv' 2>&1 | sed -n '/./{p;q;}')"
        is_recent "$version" || fail "PYTHON=$PYTHON: is Python $version; it must be 3.11 or newer"
        echo "$version $PYTHON"
        return
    fi
    found=$(list_pythons | head -n 1)
    [ -n "$found" ] || fail "no Python from 3.11 to 3.14 runs here under the names $NAMES;" \
        "install one, or name it: make PYTHON=/path/to/python3.13 ..."
    echo "$found"
}

make_environment() {
    # An environment whose making was interrupted has no pip yet.
    there=$("$VENV/bin/python" -c 'import pip' 2>/dev/null && version_of "$VENV/bin/python") || there=
    if [ -n "$there" ] && is_recent "$there" && [ -z "${PYTHON:-}" ]; then
        return
    fi
    chosen=$(chosen_python)
    version=${chosen%% *} python=${chosen#* }
    [ "$there" != "$version" ] || return 0
    if [ -e "$VENV" ]; then
        echo "remaking $VENV with $python (Python $version): it was of ${there:+Python }${there:-a Python that does not run}"
        rm -rf "$VENV"
    else
        echo "making $VENV with $python (Python $version)"
    fi
    "$python" -m venv "$VENV"
}

# Installs the project into the environment, unless that was done since pyproject.toml last changed.
install() {
    stamp=$VENV/installed-$1
    if [ -e "$stamp" ] && [ ! pyproject.toml -nt "$stamp" ]; then
        return
    fi
    echo "installing the project and what it needs into $VENV ($3)"
    "$VENV/bin/python" -m pip install --quiet --disable-pip-version-check --editable "$2"
    touch "$VENV/installed-core" "$stamp"
}

case ${1:-} in
list) list_pythons ;;
core)
    make_environment
    install core '.[graph]' 'about 0.6 GB'
    ;;
dev)
    make_environment
    install dev '.[dev]' 'about 1.4 GB'
    ;;
*) fail "usage: scripts/environment.sh core|dev|list" ;;
esac
