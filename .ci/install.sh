#!/bin/sh
# Installs the program of a release into ~/.local/bin, or into the folder that SAGNAC_BIN names:
#
#   curl -fsSL URL/install.sh | sh
#
# The archive is that of this machine; it is compared with the SHA-256 of the release before anything is written.
set -eu

# The release puts the address of its files here.
url=${SAGNAC_URL:-@URL@}
bin=${SAGNAC_BIN:-$HOME/.local/bin}

fail() {
  echo "error: $1" >&2
  exit 1
}

download() {
  if command -v curl >/dev/null; then
    curl -fsSL "$1" -o "$2"
  elif command -v wget >/dev/null; then
    wget -q "$1" -O "$2"
  else
    fail "neither curl nor wget was found. Install one of them."
  fi || fail "$1 cannot be downloaded."
}

sum() {
  if command -v sha256sum >/dev/null; then sha256sum "$1"; else shasum -a 256 "$1"; fi | cut -d ' ' -f 1
}

install() {
  case $(uname -s) in
    Linux) system=unknown-linux-gnu ;;
    Darwin) system=apple-darwin ;;
    *) fail "there is no archive for $(uname -s). On Windows unpack the zip of the release; elsewhere build from source." ;;
  esac
  case $(uname -m) in
    x86_64 | amd64) target=x86_64-$system ;;
    aarch64 | arm64) target=aarch64-$system ;;
    *) fail "there is no archive for $(uname -m). Build from source." ;;
  esac

  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  download "$url/SHA256SUMS" "$folder/SHA256SUMS"
  line=$(grep -- "-$target.tar.gz\$" "$folder/SHA256SUMS") || fail "the release has no archive for $target. Build from source."
  archive=${line##* }
  download "$url/$archive" "$folder/$archive"
  [ "$(sum "$folder/$archive")" = "${line%% *}" ] || fail "$archive is not the file of the release: its SHA-256 differs."
  tar -xzf "$folder/$archive" -C "$folder"
  mkdir -p "$bin"
  # A program that is running can be replaced, but not written to.
  mv "$folder/${archive%.tar.gz}/sagnac" "$bin/sagnac.new"
  mv "$bin/sagnac.new" "$bin/sagnac"
  echo "$("$bin/sagnac" --version) is installed as $bin/sagnac"
  case :$PATH: in
    *":$bin:"*) ;;
    *) echo "Add $bin to PATH to call it as sagnac." ;;
  esac
}

# Only a script that was downloaded as a whole gets here.
install
