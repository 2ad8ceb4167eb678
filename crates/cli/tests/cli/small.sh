# Runs $PROGRAM with the command line of a page, but with pictures, fields and tables as small as they can be; a window has
# a display that nobody sees, and ends.
command=${1-}
[ $# = 0 ] || shift
small="--size 32x32 --samples 16 --resolution 24"
case "$command $*" in
    "compare --paper"*) small="--scale 0.05 --size 12x12 --samples 48 --resolution 24 --repeat 1" ;;
    compare*) small="--size 16x16 --resolution 24 --sweep 8 --strategies procedural --repeat 1" ;;
    render* | explain*) ;;
    "stress " | "stress --"*) small="--cases 10" ;;
    stress*) small="--samples 4 --resolution 24" ;;
    bench*) small="--repeat 1 effects/lit" ;;
    field*) small="--resolution 24" ;;
    "mesh "*--tolerance*) small="--tolerance 2mm --resolution 24" ;;
    mesh* | volume*) small="--grid 16 --resolution 24" ;;
    gallery*) small="--size 16x16 --samples 8 --resolution 24" ;;
    *--script* | *--frames*) ;;
    view*)
        printf 'wait drawn\nquit\n' > "$HOME/end.$$"
        small="$small --script $HOME/end.$$"
        ;;
    *) small= ;;
esac
left=$#
while [ "$left" -gt 0 ]; do
    left=$((left - 1))
    case "$1" in
        --size | --samples | --resolution | --tolerance) shift && left=$((left - 1)) ;;
        *) set -- "$@" "$1" ;;
    esac
    shift
done
if [ "$command" = view ]; then
    Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp 3> "$HOME/display.$$" 2> /dev/null &
    server=$!
    until grep -qs . "$HOME/display.$$"; do kill -0 $server && sleep 0.1 || exit 1; done
    DISPLAY=:$(cat "$HOME/display.$$")
    export DISPLAY
    trap 'kill $server' EXIT
    "$PROGRAM" view "$@" $small
    exit
fi
exec "$PROGRAM" $command "$@" $small
