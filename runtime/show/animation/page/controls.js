// Buttons and switches, and the actions that keys share with them.

const PAN = 60; // px that a key moves the view

/** The actions of the player by name. */
export function makeActions(player) {
  const { clock, camera, timeline, shown } = player;
  const flip = (name) => () => player.flip(name, !shown[name]);
  return {
    play: () => clock.toggle(),
    forward: (frames = 1) => clock.step(frames),
    back: (frames = 1) => clock.step(-frames),
    start: () => clock.seek(clock.start),
    end: () => clock.seek(clock.end),
    nextEvent: () => timeline.goToEvent(true),
    previousEvent: () => timeline.goToEvent(false),
    faster: () => clock.change(1),
    slower: () => clock.change(-1),
    loop: () => player.loop(),
    zoomIn: () => camera.zoom(1.25),
    zoomOut: () => camera.zoom(0.8),
    fit: () => camera.toggleFit(),
    panUp: () => camera.pan(0, PAN),
    panDown: () => camera.pan(0, -PAN),
    panLeft: () => camera.pan(PAN, 0),
    panRight: () => camera.pan(-PAN, 0),
    force: flip("force"),
    reaction: flip("reaction"),
    torque: flip("torque"),
    names: flip("names"),
    frames: flip("frames"),
    traces: flip("traces"),
    nextElement: () => player.chooseNext(1),
    previousElement: () => player.chooseNext(-1),
    tellAll: () => player.tellAll(),
    theme: () => player.changeTheme(),
    help: () => document.querySelector("#help").showModal(),
  };
}

/** Connects buttons with actions, and keeps their labels true. */
export function connectControls(root, player, actions) {
  const { clock } = player;
  for (const button of root.querySelectorAll("[data-action]")) {
    button.addEventListener("click", () => actions[button.dataset.action]());
  }
  const speed = root.querySelector("#speed");
  for (const value of clock.speeds) speed.append(new Option(`${value} ×`, value));
  speed.addEventListener("change", () => {
    clock.speed = Number(speed.value);
    clock.notify();
  });
  for (const box of root.querySelectorAll("[data-layer]")) {
    box.addEventListener("change", () => player.flip(box.dataset.layer, box.checked));
  }
  const play = root.querySelector('[data-action="play"]');
  let was;
  const refresh = () => {
    const now = `${clock.playing} ${clock.speed}`;
    if (now === was) return;
    was = now;
    play.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    play.classList.toggle("playing", clock.playing);
    speed.value = clock.speed;
  };
  clock.onTick(refresh);
  refresh();
}
