#!/bin/sh
# Renders the pictures of README and docs anew, 1280 pixels wide, denoised: docs/gallery.sh [NAME...]
#
# Each takes one to five minutes on two cores. JPEG files are made where Pillow is there (pip install pillow); else PNG files stay.
set -eu
self=$(readlink -f -- "$0")
root=${self%/docs/*}
cd -- "$root"
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

# name, width x height, samples a pixel, further flags
pictures='
terrace           1280x720  64 --denoise
kerr_disc         1280x720  64
shadow_stars      1280x720  1
gold_dragon       1280x960  24 --denoise
cornell_box       1280x1280 24 --denoise
cornell_hole      1280x960  24 --denoise
spheres           1280x960  32 --denoise
spheres_hole      1280x960  32 --denoise
bunny_hole        1280x960  16 --denoise
blueshift         1280x960  16 --denoise
redshift_spheres  1280x960  16 --denoise
redshift_wall     1280x960  16 --denoise
frames_static     1280x960   8 --denoise
frames_chart      1280x960   8 --denoise
dragon_army       1280x800  12 --denoise
prism             1280x854  64 --denoise
wormhole          1280x960  12 --denoise
two_holes         1280x854  12 --denoise
moving_camera     1280x854  16 --denoise
kerr_room         1280x960   8 --denoise
disc_in_room      1280x960   4 --denoise
'

echo "$pictures" | while read -r name size samples flags; do
    [ -n "$name" ] || continue
    [ $# = 0 ] || case " $* " in *" $name "*) ;; *) continue ;; esac
    # shellcheck disable=SC2086 # several flags
    ./bhs render "scenes/$name.bhs" --resolution "$size" --spp "$samples" $flags -o "$folder/$name.exr"
    python3 - "$folder/$name.png" "docs/$name.jpg" <<'PYTHON' || cp -- "$folder/$name.png" "docs/$name.png"
import sys
from PIL import Image
Image.open(sys.argv[1]).convert("RGB").save(sys.argv[2], quality=90, optimize=True, progressive=True)
PYTHON
done
